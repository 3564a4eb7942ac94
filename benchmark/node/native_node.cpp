// Copyright screw_kinematics contributors
// SPDX-License-Identifier: Apache-2.0
//
// A node in C++ on rcl: typed messages, kinematics in C as our program writes it, accelerations of
// the joints taken as zero. What any node costs that is not in Python; rclcpp comes on top.
//
// usage: native_node ROBOTS
#include <csignal>
#include <cstdlib>
#include <iostream>
#include <string>
#include <unordered_map>
#include <vector>

#include <geometry_msgs/msg/accel_stamped.h>
#include <geometry_msgs/msg/twist_stamped.h>
#include <rcl/error_handling.h>
#include <rcl/rcl.h>
#include <rosidl_runtime_c/string_functions.h>
#include <sensor_msgs/msg/joint_state.h>

#include "joints.h"   // JOINTS, BASE
extern "C" {
#include "tip.h"      // tip(q, qd, qdd, twist, accel), angular first
}

namespace
{
constexpr int N = sizeof(JOINTS) / sizeof(*JOINTS);
constexpr int64_t WAIT_NS = 100'000'000;
volatile std::sig_atomic_t stopped = 0;

void check(rcl_ret_t result)
{
  if (result != RCL_RET_OK) {
    std::cerr << rcl_get_error_string().str << std::endl;
    std::exit(1);
  }
}

void set(geometry_msgs__msg__Vector3 & out, const double * in)
{
  out.x = in[0];
  out.y = in[1];
  out.z = in[2];
}

class Robot
{
public:
  Robot(rcl_node_t * node, const std::string & name)
  {
    for (int i = 0; i < N; ++i) {
      place_[JOINTS[i]] = i;
    }
    auto input = rcl_subscription_get_default_options();
    input.qos.depth = 100;
    const auto output = rcl_publisher_get_default_options();
    check(rcl_subscription_init(
        &subscription, node, ROSIDL_GET_MSG_TYPE_SUPPORT(sensor_msgs, msg, JointState),
        (name + "/joint_states").c_str(), &input));
    check(rcl_publisher_init(
        &twist_publisher_, node, ROSIDL_GET_MSG_TYPE_SUPPORT(geometry_msgs, msg, TwistStamped),
        (name + "/twist").c_str(), &output));
    check(rcl_publisher_init(
        &accel_publisher_, node, ROSIDL_GET_MSG_TYPE_SUPPORT(geometry_msgs, msg, AccelStamped),
        (name + "/accel").c_str(), &output));
    sensor_msgs__msg__JointState__init(&joints_);
    geometry_msgs__msg__TwistStamped__init(&twist_);
    geometry_msgs__msg__AccelStamped__init(&accel_);
    rosidl_runtime_c__String__assign(&twist_.header.frame_id, BASE);
    rosidl_runtime_c__String__assign(&accel_.header.frame_id, BASE);
  }

  void take()
  {
    rmw_message_info_t info;
    if (rcl_take(&subscription, &joints_, &info, nullptr) != RCL_RET_OK) {
      return;
    }
    for (size_t k = 0; k < joints_.name.size; ++k) {
      const auto found = place_.find(joints_.name.data[k].data);
      if (found != place_.end()) {
        q_[found->second] = joints_.position.data[k];
        qd_[found->second] = joints_.velocity.data[k];
      }
    }
    double twist[6], accel[6];
    tip(q_, qd_, qdd_, twist, accel);
    twist_.header.stamp = accel_.header.stamp = joints_.header.stamp;
    set(twist_.twist.angular, twist);
    set(twist_.twist.linear, twist + 3);
    set(accel_.accel.angular, accel);
    set(accel_.accel.linear, accel + 3);
    check(rcl_publish(&twist_publisher_, &twist_, nullptr));
    check(rcl_publish(&accel_publisher_, &accel_, nullptr));
  }

  rcl_subscription_t subscription = rcl_get_zero_initialized_subscription();

private:
  std::unordered_map<std::string, int> place_;
  double q_[N] = {}, qd_[N] = {}, qdd_[N] = {};
  rcl_publisher_t twist_publisher_ = rcl_get_zero_initialized_publisher();
  rcl_publisher_t accel_publisher_ = rcl_get_zero_initialized_publisher();
  sensor_msgs__msg__JointState joints_;
  geometry_msgs__msg__TwistStamped twist_;
  geometry_msgs__msg__AccelStamped accel_;
};
}  // namespace

int main(int argc, char ** argv)
{
  const size_t count = argc > 1 ? std::atoi(argv[1]) : 1;
  std::signal(SIGINT, [](int) {stopped = 1;});
  std::signal(SIGTERM, [](int) {stopped = 1;});
  const rcl_allocator_t allocator = rcl_get_default_allocator();
  auto init = rcl_get_zero_initialized_init_options();
  check(rcl_init_options_init(&init, allocator));
  auto context = rcl_get_zero_initialized_context();
  check(rcl_init(0, nullptr, &init, &context));
  auto node = rcl_get_zero_initialized_node();
  auto options = rcl_node_get_default_options();
  options.enable_rosout = false;
  check(rcl_node_init(&node, "native", "", &context, &options));

  std::vector<Robot> robots;
  robots.reserve(count);
  for (size_t i = 0; i < count; ++i) {
    robots.emplace_back(&node, "r" + std::to_string(i));
  }
  auto ready = rcl_get_zero_initialized_wait_set();
  check(rcl_wait_set_init(&ready, count, 0, 0, 0, 0, 0, &context, allocator));
  while (!stopped) {
    check(rcl_wait_set_clear(&ready));
    for (auto & robot : robots) {
      check(rcl_wait_set_add_subscription(&ready, &robot.subscription, nullptr));
    }
    if (rcl_wait(&ready, WAIT_NS) != RCL_RET_OK) {
      continue;
    }
    for (size_t i = 0; i < count; ++i) {
      if (ready.subscriptions[i]) {
        robots[i].take();
      }
    }
  }
  return 0;
}
