"""No class at all: loaders return functions, main ties them together.

field: all
"""

import functools
import math
import pickle
import statistics
from pathlib import Path

import numpy as np
import rclpy
from geometry_msgs.msg import Twist
from rclpy.executors import ExternalShutdownException
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan


def from_pickle(path, _device, _warn):
    model = pickle.loads(Path(path).read_bytes())
    return lambda row: model.predict(row)


def from_onnx(path, _device, _warn):
    from onnxruntime import InferenceSession, SessionOptions

    options = SessionOptions()
    options.intra_op_num_threads = 1
    session = InferenceSession(path, options)
    given, said = session.get_inputs()[0].name, session.get_outputs()[0].name
    return lambda row: session.run([said], {given: row})


def from_torch(path, device, warn):
    import torch

    program = torch.export.load(path)
    if device == "cuda" and not torch.cuda.is_available():
        warn("there is no CUDA device, so this runs on the CPU")
    elif device == "cuda":
        program = torch.export.passes.move_to_device_pass(program, "cuda")
        module = program.module()
        return lambda row: module(torch.from_numpy(row).cuda()).detach().cpu()
    module = program.module()
    return lambda row: module(torch.from_numpy(row)).detach()


def from_keras(path, _device, _warn):
    import keras

    model = keras.saving.load_model(path)
    return lambda row: keras.ops.convert_to_numpy(model(row, training=False))


LOADERS = {".pkl": from_pickle, ".onnx": from_onnx, ".pt2": from_torch, ".keras": from_keras}


def no_policy(_row):
    return 0.0


def load(path, device, log):
    if device != "cpu" and not path.lower().endswith(".pt2"):
        log.warning(f"device = {device} means nothing to {path}")
    try:
        return LOADERS[Path(path.lower()).suffix](path, device, log.warning)
    except KeyError:
        log.error(f"{path}: the suffix is none of {' '.join(LOADERS)}")
    except Exception as error:
        log.error(f"{path} is of no use: {error}")
    return no_policy


def sector(scan, contains):
    found = []
    for index, reading in enumerate(scan.ranges):
        angle = math.remainder(scan.angle_min + index * scan.angle_increment, math.tau)
        if reading == -math.inf:
            reading = scan.range_min
        if contains(math.degrees(angle)) and reading >= scan.range_min:
            found.append(min(reading, scan.range_max))
    return found


def features(scan):
    front = sector(scan, lambda degrees: abs(degrees) <= 60)
    left = sector(scan, lambda degrees: degrees > 60)
    right = sector(scan, lambda degrees: degrees < -60)
    return (
        min(front),
        statistics.fmean(front),
        statistics.pstdev(front),
        min(left),
        min(right),
    )


def on_scan(policy, max_speed, publish, log, scan):
    twist = Twist()
    try:
        speed = float(np.asarray(policy(np.array([features(scan)], np.float32))).reshape(()))
        if math.isfinite(speed):
            twist.linear.x = max(0.0, min(max_speed, speed))
    except Exception as error:
        log.warning(f"standing still: {error!r}")
    publish(twist)


def main(args=None):
    rclpy.init(args=args)
    node = rclpy.create_node("policy_controller")
    path = node.declare_parameter("model_path", "velocity_model.pkl").value
    max_speed = node.declare_parameter("max_speed", 0.5).value
    device = node.declare_parameter("device", "cpu").value
    log = node.get_logger()
    policy = load(path, device, log)
    publisher = node.create_publisher(Twist, "/cmd_vel", 10)
    callback = functools.partial(on_scan, policy, max_speed, publisher.publish, log)
    node.create_subscription(
        LaserScan, "/scan", lambda scan: callback(scan), qos_profile_sensor_data
    )
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
