"""Prove the graders, and make what students are handed."""
