"""The command line of drivegate with the contract of this folder."""

from drivegate.commands.command_line import main

main()
