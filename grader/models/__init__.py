"""The models that nodes load, and the five features that they are asked about."""
