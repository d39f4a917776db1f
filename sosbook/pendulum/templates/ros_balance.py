#!/usr/bin/env python3
"""Let ROS 2 drive the robot: cmd_vel goes to rc_balance, which balances.

(Where this comes from.)

    python3 ros_balance.py [log.csv]

starts ./rc_balance and sends it the last message of the topic cmd_vel
(geometry_msgs/Twist): linear.x in m/s forward, angular.z in rad/s to the left.
The program keeps its own clock and limits, and stops the wheels a second
after the last message.
"""

import subprocess
import sys

NODE = "balance"  # its name
RADIUS = 0.032  # m, of the wheels


def line(forward, turn):
    """What rc_balance reads: wheels in rad/s, the heading in rad/s."""
    return f"v {forward / RADIUS:.6f} {turn:.6f}\n"


def main():
    """Run until the program or the node ends."""
    import rclpy
    from geometry_msgs.msg import Twist

    log = sys.argv[1] if len(sys.argv) > 1 else "/dev/null"
    rclpy.init()
    node = rclpy.create_node(NODE)
    program = subprocess.Popen(
        ["./rc_balance", log, "-"], stdin=subprocess.PIPE, text=True, encoding="utf-8"
    )

    def obey(twist):
        if program.poll() is None:
            program.stdin.write(line(twist.linear.x, twist.angular.z))
            program.stdin.flush()

    node.create_subscription(Twist, "cmd_vel", obey, 1)
    try:
        while program.poll() is None and rclpy.ok():
            rclpy.spin_once(node, timeout_sec=0.1)
    except (KeyboardInterrupt, BrokenPipeError):
        pass
    finally:
        program.terminate()  # it turns the motors off
        program.wait()
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
