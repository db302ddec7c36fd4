"""Design of linkages: dimensions that give a motion, and counterweights that keep the frame at rest."""
