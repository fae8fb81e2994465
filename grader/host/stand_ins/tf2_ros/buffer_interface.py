"""Where tf2_ros has its registrations."""

from .conversions import ConvertRegistration, TransformRegistration, TypeException, convert

__all__ = ["ConvertRegistration", "TransformRegistration", "TypeException", "convert"]
