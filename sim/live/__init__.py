"""The mock robot as a real ROS 2 node, in real time: the only place in `sim` that imports rclpy.

The logic (`timeline`, `robot`, `health`, `topics`) knows nothing of ROS; `sending`, `hearing`,
`parameters`, `node` and `run` do.
"""
