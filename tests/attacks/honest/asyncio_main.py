"""Runs ROS under asyncio: spins a little, lets other coroutines go on, and so forth."""

import asyncio

import rclpy
from rclpy.executors import SingleThreadedExecutor
from seeing import Agent


async def spin(executor):
    while rclpy.ok():
        executor.spin_once(timeout_sec=0)
        await asyncio.sleep(0.005)


async def main():
    rclpy.init()
    executor = SingleThreadedExecutor()
    executor.add_node(Agent())
    await asyncio.gather(spin(executor), asyncio.sleep(1.0))


asyncio.run(main())
