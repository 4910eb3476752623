"""The ways in which a run ends without a verdict on a candidate."""


class InputError(Exception):
    """Something that a person or a file requested cannot be done as requested.

    The message is one sentence for that person: what is wrong, where, and what would be right. The command
    line prints it, without a traceback, and exits with code 2.
    """


class HarnessFault(Exception):
    """The harness itself, or its reference plant, broke a rule that it guarantees.

    No verdict on a candidate can be trusted then. The command line exits with code 3.
    """


class OutOfMemory(HarnessFault):
    """The machine has too little memory.

    The message is one sentence with what is needed. The command line prints it, and exits with code 3.
    """
