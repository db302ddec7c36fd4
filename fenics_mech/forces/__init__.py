"""Forces of a motion: on the ends of elements, in sections, at joints and at drives."""
