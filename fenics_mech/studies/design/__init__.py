"""From analysis to design: what a study varies, the numbers that it looks at, and its trials."""
