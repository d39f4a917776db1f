#!/usr/bin/env python3
"""A node of ROS 2 beside rc_balance, which balances: orders in, readings out.

(Where this comes from.)

In a workspace with this folder, on the robot:

    colcon build
    ros2 run ros_balance ros_balance.py --ros-args -p program:=/root/rc_balance

It hears
    cmd_vel (geometry_msgs/Twist): linear.x in m/s forward, angular.z in rad/s to
        the left; the wheels stop a second after the last one
    go (geometry_msgs/Pose): position.x is the way in m since the start, the
        orientation's yaw the heading; there it goes, and stays
and says, twenty times a second,
    odom (nav_msgs/Odometry), by the wheels
    joint_states (sensor_msgs/JointState): both wheels against the body
    battery_state (sensor_msgs/BatteryState): its volts
    diagnostics (diagnostic_msgs/DiagnosticArray): the fault, and ticks that came late
The program keeps its own clock and limits; the node takes part in no tick.
"""

import math
import os
import subprocess
import threading
from collections import deque

NODE = "balance"  # its name
RADIUS = 0.032  # m, of the wheels
PER_RADIAN = 2.5  # rad right less left, a radian of heading
HERTZ = 20.0  # Hz, at which it says what it knows
FAULTS = ("running", "sensor", "fall", "stall", "command", "late")
READ = "t", "theta", "battery", "fault", "late", "left", "right"


def speed_line(forward, turn):
    """A line for rc_balance: wheels in rad/s, the heading in rad/s."""
    return f"v {forward / RADIUS:.6f} {turn:.6f}\n"


def place_line(way, heading):
    """Likewise: wheels and heading in rad, since the start."""
    return f"p {way / RADIUS:.6f} {heading:.6f}\n"


def yaw_of(q):
    """The heading of a quaternion, in rad."""
    return math.atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y**2 + q.z**2))


class Odometer:
    """Where the robot is, by the rows of the program's log."""

    def __init__(self):
        self.names, self.row, self.ends = None, None, None
        self.x = self.y = self.yaw = self.forward = self.turning = 0.0

    def read(self, line):
        """Go on by a line of the log; whether it was a tick."""
        words = line.strip().split(",")
        if words[0] == "t":
            self.names = words
        if self.names is None or len(words) != len(self.names) or words[0] == "t":
            return False
        named = dict(zip(self.names, map(float, words)))
        row = {name: named[name] for name in READ}
        way = RADIUS * ((row["left"] + row["right"]) / 2 + row["theta"])
        ends = row["t"], way, (row["right"] - row["left"]) / PER_RADIAN
        if not all(map(math.isfinite, ends)):
            return False
        started = self.row is None or row["fault"] < 0
        time, way, turn = (0.0,) * 3 if started else map(float.__sub__, ends, self.ends)
        self.row, self.ends = row, ends
        self.x += way * math.cos(self.yaw + turn / 2)
        self.y += way * math.sin(self.yaw + turn / 2)
        self.yaw += turn
        if time > 0:
            self.forward, self.turning = way / time, turn / time
        return True


def started(program, log):
    """rc_balance as a process, and a deque to which its log's lines come."""
    ours, theirs = os.pipe()
    words = [program, f"/dev/fd/{theirs}", "-"]
    process = subprocess.Popen(
        words, stdin=subprocess.PIPE, text=True, encoding="utf-8", pass_fds=[theirs]
    )
    os.close(theirs)
    lines = deque()

    def listen():
        with open(ours, encoding="utf-8") as rows, open(log, "w", -1, "utf-8") as copy:
            for line in rows:
                copy.write(line)
                lines.append(line)

    threading.Thread(target=listen, daemon=True).start()
    return process, lines


def main():
    """Run until the program or the node ends."""
    import rclpy
    from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
    from geometry_msgs.msg import Pose, Twist
    from nav_msgs.msg import Odometry
    from sensor_msgs.msg import BatteryState, JointState

    rclpy.init()
    node, odometer = rclpy.create_node(NODE), Odometer()
    program, log, odom_frame, base_frame = (
        node.declare_parameter(name, value).value
        for name, value in (
            ("program", "./rc_balance"),
            ("log", os.devnull),
            ("odom_frame", "odom"),
            ("base_frame", "base_link"),
        )
    )
    process, lines = started(program, log)

    def order(line):
        if process.poll() is None:
            process.stdin.write(line)
            process.stdin.flush()

    def obey(twist):
        order(speed_line(twist.linear.x, twist.angular.z))

    def go(pose):
        order(place_line(pose.position.x, yaw_of(pose.orientation)))

    node.create_subscription(Twist, "cmd_vel", obey, 1)
    node.create_subscription(Pose, "go", go, 1)
    says = {
        topic: node.create_publisher(kind, topic, 10)
        for topic, kind in (
            ("odom", Odometry),
            ("joint_states", JointState),
            ("battery_state", BatteryState),
            ("diagnostics", DiagnosticArray),
        )
    }

    def say(topic, message):
        message.header.stamp = node.get_clock().now().to_msg()
        says[topic].publish(message)

    def tell():
        """Say what the ticks since the last time told."""
        ticks = [odometer.read(lines.popleft()) for _ in range(len(lines))]
        if not any(ticks):
            return
        row, odom, joints = odometer.row, Odometry(), JointState()
        odom.header.frame_id, odom.child_frame_id = odom_frame, base_frame
        pose, twist = odom.pose.pose, odom.twist.twist
        pose.position.x, pose.position.y = odometer.x, odometer.y
        pose.orientation.z = math.sin(odometer.yaw / 2)
        pose.orientation.w = math.cos(odometer.yaw / 2)
        twist.linear.x, twist.angular.z = odometer.forward, odometer.turning
        say("odom", odom)
        joints.name = ["left_wheel_joint", "right_wheel_joint"]
        joints.position = [row["left"], row["right"]]
        say("joint_states", joints)
        battery = BatteryState()
        battery.voltage, battery.present = row["battery"], True
        say("battery_state", battery)
        fault = max(int(row["fault"]), 0)
        level = DiagnosticStatus.ERROR if fault else DiagnosticStatus.OK
        values = [("tilt", f"{row['theta']:.4f} rad"), ("late", f"{row['late']:.0f}")]
        diagnostics = DiagnosticArray()
        diagnostics.status = [
            DiagnosticStatus(
                level=level,
                name=NODE,
                message=FAULTS[fault],
                values=[KeyValue(key=key, value=value) for key, value in values],
            )
        ]
        say("diagnostics", diagnostics)

    node.create_timer(1 / HERTZ, tell)
    try:
        while process.poll() is None and rclpy.ok():
            rclpy.spin_once(node, timeout_sec=0.1)
    except (KeyboardInterrupt, BrokenPipeError):
        pass
    finally:
        process.terminate()  # it turns the motors off
        process.wait()
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
