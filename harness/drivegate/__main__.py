"""``python -m drivegate``: the command line, also where no folder of scripts is on the search path."""

from drivegate.commands.command_line import main

if __name__ == "__main__":
    main()
