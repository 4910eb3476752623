"""What each command does, one folder a command."""
