"""Laws of joints: the forces of friction, contact and soft bearings by the state of a joint. One law a file."""
