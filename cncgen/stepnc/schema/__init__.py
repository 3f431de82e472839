"""What entities there are and which attributes they have, and the check of a file against it."""
