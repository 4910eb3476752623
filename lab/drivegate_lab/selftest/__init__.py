"""The checks themselves checked, with faulty and with correct controllers."""
