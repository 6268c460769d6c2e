"""What runs inside: nothing here may import the judge, for the worker must not hold it."""
