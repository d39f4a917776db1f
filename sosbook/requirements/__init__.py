"""What can be asked of a loop."""
