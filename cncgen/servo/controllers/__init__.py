"""Controllers, a file each, with its source and equations."""
