"""A third contract, all of it in this folder: a DC motor whose controller answers with a voltage.

Importing it enters the contract, its kind of drive and its controllers into their tables. Nothing else of drivegate
knows it.
"""

from tests.toy_contract import contract

__all__ = ["contract"]
