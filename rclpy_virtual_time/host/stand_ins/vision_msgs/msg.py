"""The messages of vision_msgs."""

from rclpy_virtual_time.host.interfaces import define

HEADER = "std_msgs/Header header\n"

globals().update(
    define("vision_msgs", {
        "Point2D": "float64 x\nfloat64 y",
        "Pose2D": "Point2D position\nfloat64 theta",
        "BoundingBox2D": "Pose2D center\nfloat64 size_x\nfloat64 size_y",
        "BoundingBox2DArray": HEADER + "BoundingBox2D[] boxes",
        "BoundingBox3D": "geometry_msgs/Pose center\ngeometry_msgs/Vector3 size",
        "BoundingBox3DArray": HEADER + "BoundingBox3D[] boxes",
        "ObjectHypothesis": "string class_id\nfloat64 score",
        "ObjectHypothesisWithPose":
            "ObjectHypothesis hypothesis\ngeometry_msgs/PoseWithCovariance pose",
        "Classification": HEADER + "ObjectHypothesis[] results",
        "Detection2D":
            HEADER + "ObjectHypothesisWithPose[] results\nBoundingBox2D bbox\nstring id",
        "Detection2DArray": HEADER + "Detection2D[] detections",
        "Detection3D":
            HEADER + "ObjectHypothesisWithPose[] results\nBoundingBox3D bbox\nstring id",
        "Detection3DArray": HEADER + "Detection3D[] detections",
        "VisionClass": "uint16 class_id\nstring class_name",
        "LabelInfo": HEADER + "VisionClass[] class_map\nfloat32 threshold",
        "VisionInfo":
            HEADER + "string method\nstring database_location\nint32 database_version",
    })
)  # fmt: skip
