"""The node of ROS 2: beside the program itself, and with stand-ins for ROS."""

import sys
import xml.etree.ElementTree as ElementTree
from collections import deque
from types import SimpleNamespace
from unittest.mock import MagicMock

import numpy as np
import pytest

import tests.test_mip_export as programs
from sosbook.pendulum import Robot
from sosbook.pendulum.export import Program as Written
from tests.test_mip_steering import FIRMWARE, LIMITS, LINES, ROBOT, STEERING, heard

WHOLE = Written(FIRMWARE, robot=ROBOT, steering=STEERING)


def node():
    """What the node's text defines."""
    space = {"__name__": "script"}
    text = WHOLE.ros["ros_balance/ros_balance.py"]
    exec(compile(text, "ros_balance.py", "exec"), space)
    return space


def rows(wheels, fault=0):
    """Lines of the program's log, ten ms apart, by both wheels' angles in rad."""
    yield "t,gyro,wheels,tilt,target,rate,V,theta,battery,fault,late,left,right\n"
    for k, (left, right) in enumerate(wheels):
        last = fault if k == len(wheels) - 1 else 0 if k else -1
        yield f"{k / 100},0,0,0,0,0,1,0.1,7.4,{last},2,{left},{right}\n"


def test_it_is_a_package_that_colcon_builds():
    files = WHOLE.ros
    about = ElementTree.fromstring(files["ros_balance/package.xml"])
    builds = files["ros_balance/CMakeLists.txt"]
    assert about.findtext("name") == "ros_balance"
    assert "project(ros_balance)" in builds and "PROGRAMS ros_balance.py" in builds
    text = files["ros_balance/ros_balance.py"]
    needs = {x.text for x in about.iter("exec_depend")}
    used = {x.split()[1].split(".")[0] for x in text.splitlines() if "_msgs.msg" in x}
    assert needs == {"rclpy"} | {x for x in used if x.endswith("_msgs")}
    with pytest.raises(ValueError, match="this program is for a BeagleBone"):
        Written(FIRMWARE, robot=Robot.shipped("gearmotors"), steering=STEERING).ros
    with pytest.raises(ValueError, match="without track"):
        Written(FIRMWARE, robot=ROBOT).ros


def test_its_odometry_is_a_circle_in_closed_form():
    """One wheel of 34 mm rolls twice as far as the other: a circle, run in a lap."""
    space, r, track = node(), ROBOT.r, ROBOT.track
    inner = np.linspace(0, 2 * np.pi * track / r, 2001)
    odometer = space["Odometer"]()
    heard = [odometer.read(x) for x in rows(np.column_stack([inner, 2 * inner]))]
    assert heard == [False] + 2001 * [True]
    assert odometer.yaw == pytest.approx(2 * np.pi)
    assert np.hypot(odometer.x, odometer.y) < 1e-3 * track
    assert odometer.turning == pytest.approx(2 * np.pi / 20, rel=1e-9)
    assert odometer.forward == pytest.approx(1.5 * track * odometer.turning)
    for line in ("", "0,1\n", next(iter(rows([])))):
        assert not odometer.read(line)
    x, y, yaw = odometer.x, odometer.y, odometer.yaw
    for line in rows([(0.0, 0.0), (1.0, 1.0)]):  # a second start: no way is lost
        odometer.read(line)
    assert odometer.yaw == yaw
    ahead = odometer.x - x + 1j * (odometer.y - y)
    assert ahead == pytest.approx(r * np.exp(1j * yaw))


@pytest.mark.skipif(sys.platform == "win32", reason="pipes of POSIX")
def test_it_reads_what_the_program_writes(gcc, tmp_path):
    """The program with the library's stand-in, its log a pipe and a file."""
    robot = programs.Robot(
        gcc, tmp_path, FIRMWARE, stub=LINES, drive=LIMITS, steering=STEERING
    )
    space, moves = node(), programs.moves(200)
    before = set(space["threading"].enumerate())
    process, lines = space["started"](robot.folder / "rc_balance", tmp_path / "log.csv")
    for row in [*programs.REST, *moves]:
        words = (x if isinstance(x, str) else repr(x) for x in row)
        process.stdin.write(" ".join(words) + "\n")
    process.stdin.close()
    assert process.wait(60) == 0
    for thread in {*space["threading"].enumerate()} - before:
        thread.join(10)
    odometer = space["Odometer"]()
    assert sum(map(odometer.read, lines)) == 201
    (left, right), (at_left, at_right) = heard(moves)[-1], heard(programs.REST)[-1]
    turned = (right - at_right - left + at_left) * ROBOT.r / ROBOT.track
    assert odometer.yaw == pytest.approx(turned)
    assert (tmp_path / "log.csv").read_text("utf-8") == "".join(lines)


def test_it_passes_orders_on_and_tells_what_it_knows(monkeypatch):
    rclpy, process, asked = MagicMock(), MagicMock(), []
    ros, process.poll.return_value = rclpy.create_node.return_value, None
    rclpy.ok.side_effect = [True, False]
    for name in ("geometry", "nav", "sensor", "diagnostic"):
        monkeypatch.setitem(sys.modules, f"{name}_msgs", rclpy)
        monkeypatch.setitem(sys.modules, f"{name}_msgs.msg", rclpy)
    monkeypatch.setitem(sys.modules, "rclpy", rclpy)
    ros.declare_parameter.side_effect = lambda name, value: SimpleNamespace(value=value)
    said = {}
    ros.create_publisher.side_effect = lambda kind, topic, depth: SimpleNamespace(
        publish=lambda message: said.update({topic: message})
    )
    space = node()

    def started(program, log):
        asked.append(program)
        return process, deque(rows([(0.0, 0.0), (2.0, 1.0), (4.0, 2.0)], fault=3))

    def spin(*_, **__):
        orders = {x.args[1]: x.args[2] for x in ros.create_subscription.call_args_list}
        point = SimpleNamespace
        orders["cmd_vel"](point(linear=point(x=0.17), angular=point(z=-0.5)))
        yaw = point(x=0.0, y=0.0, z=np.sin(0.6), w=np.cos(0.6))
        orders["go"](point(position=point(x=0.34), orientation=yaw))
        hertz, tell = ros.create_timer.call_args.args
        tell()
        tell()  # nothing new

    rclpy.spin_once.side_effect = spin
    space["started"] = started
    space["main"]()
    orders = [call.args[0] for call in process.stdin.write.call_args_list]
    # 0.17 m/s on wheels of 34 mm, then 0.34 m with 1.2 rad to the left
    assert orders == ["v 5.000000 -0.500000\n", "p 10.000000 1.200000\n"]
    assert asked == ["./rc_balance"] and process.stdin.flush.call_count == 2
    yaw = -2.0 * ROBOT.r / ROBOT.track
    pose = said["odom"].pose.pose
    assert 2 * np.arctan2(pose.orientation.z, pose.orientation.w) == pytest.approx(yaw)
    assert said["odom"].twist.twist.angular.z == pytest.approx(yaw / 0.02)
    assert said["odom"].header.frame_id == "odom"
    assert said["joint_states"].position == [4.0, 2.0]
    assert said["battery_state"].voltage == 7.4
    (told,) = (x.kwargs for x in rclpy.DiagnosticStatus.call_args_list)
    assert told["message"] == "stall" and told["level"] == rclpy.DiagnosticStatus.ERROR
    values = {x.kwargs["key"]: x.kwargs["value"] for x in rclpy.KeyValue.call_args_list}
    assert values == {"tilt": "0.1000 rad", "late": "2"}
    ends = process.terminate, process.wait, ros.destroy_node, rclpy.try_shutdown
    assert all(end.called for end in ends)
