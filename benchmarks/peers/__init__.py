"""Peers: other programs that solve the same mechanisms, as independent references. Each is an extra to install."""
