#pragma once
// Random MJCF models that combine many features of the format, restricted to those that MuJoCo 2.2.2 accepts.

#include <random>
#include <string>

#include "ugoki/base/number.h"
#include "ugoki/spatial/spatial.h"

namespace ugoki::robot_formats {

class RandomMjcf {
 public:
  explicit RandomMjcf(unsigned seed) : random_(seed) {}

  std::string make() {
    degrees_ = below(2) == 0;
    const char* const orders[] = {"xyz", "ZYX", "zXy", "XYZ", "yzx"};
    out_ = "<mujoco model='random'><compiler angle='" + std::string(degrees_ ? "degree" : "radian") + "' eulerseq='" + orders[below(5)] +
           "' inertiafromgeom='" + (below(4) == 0 ? "true" : "auto") + "' balanceinertia='" + (below(2) == 0 ? "true" : "false") + "'" +
           (below(4) == 0 ? " boundmass='3' boundinertia='0.05'" : "") + (below(4) == 0 ? " settotalmass='20'" : "") +
           (below(3) == 0 ? " inertiagrouprange='0 2'" : "") + "/>";
    out_ +=
        "<default><geom density='700' friction='0.3 0.1'/><joint damping='0.2'/><default class='a'><geom type='capsule' size='0.1 0.2'/>"
        "<joint axis='1 2 0.5' pos='0.1 0 0' armature='0.01'/><site pos='0.1 0 0'/><default class='b'><geom type='box' size='0.1 0.2 "
        "0.15' " +
        orientation() +
        "/><joint type='slide' stiffness='3' springref='0.1'/></default></default><default class='c'><geom type='ellipsoid' "
        "size='0.2 0.1 0.15' group='3'/><joint range='-0.5 0.75' frictionloss='0.1'/></default></default><worldbody>";
    const int trees = 1 + below(3);
    for (int i = 0; i < trees; ++i) body(0);
    out_ += "</worldbody><equality>" + equalities() + "</equality></mujoco>";
    return out_;
  }

 private:
  int below(int n) { return static_cast<int>(random_() % static_cast<unsigned>(n)); }
  double in(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  std::string numbers(int n, double reach) {
    std::string out;
    for (int i = 0; i < n; ++i) out += to_text(in(-reach, reach)) + " ";
    return out;
  }
  std::string angle(double reach) { return to_text(in(-reach, reach) * (degrees_ ? 180 / pi : 1)); }

  /// A random orientation attribute. @param over_euler true: the default class sets `euler`. MuJoCo 2.2.2 then accepts only `quat` and
  /// `euler` with the expected effect.
  std::string orientation(bool over_euler = false) {
    switch (over_euler ? below(2) : below(6)) {
      case 0: return "quat='" + numbers(4, 1) + "'";
      case 1: return "euler='" + angle(2) + " " + angle(2) + " " + angle(2) + "'";
      case 2: return "axisangle='" + numbers(3, 1) + angle(3) + "'";
      case 3: return "xyaxes='" + numbers(6, 1) + "'";
      case 4: return "zaxis='" + (below(4) == 0 ? std::string("0 0 -2") : numbers(3, 1)) + "'";
      default: return "";
    }
  }
  std::string pose(double reach, bool over_euler = false) { return "pos='" + numbers(3, reach) + "' " + orientation(over_euler); }
  std::string in_class(int i) {
    const char* const classes[] = {"class='b'", "class='a'", "class='c'", "", ""};
    return classes[i];
  }

  void geom() {
    // Class 'c' has a geom group that may be excluded from the mass; 'fromto' cannot be combined with the orientation of class 'b'.
    const char* const types[] = {"sphere", "capsule", "ellipsoid", "cylinder", "box"};
    out_ += "<geom ";
    if (below(3) == 0) {
      out_ += "type='" + std::string(types[1 + below(4)]) + "' size='" + to_text(in(0.05, 0.2)) + "' fromto='" + numbers(6, 0.3) +
              "' class='main'";
    } else if (below(2) == 0) {
      const int c = below(5);
      out_ += in_class(c) + " type='" + std::string(types[below(5)]) + "' size='" + to_text(in(0.05, 0.2)) + " " + to_text(in(0.05, 0.2)) +
              " " + to_text(in(0.05, 0.2)) + "' " + pose(0.3, c == 0);
    } else {
      const int c = below(3);
      out_ += in_class(c) + " " + pose(0.3, c == 0);
    }
    if (below(3) == 0) out_ += " mass='" + to_text(in(0.5, 3)) + "'";
    if (below(3) == 0) out_ += " density='" + to_text(in(200, 2000)) + "'";
    out_ += "/>";
  }

  void joint(const char* type) {
    const std::string name = "j" + std::to_string(joints_++);
    if (std::string(type) != "ball") scalar_joints_.push_back(name);
    out_ += "<joint name='" + name + "' type='" + type + "' pos='" + numbers(3, 0.2) + "' " +
            (below(2) == 0 ? in_class(below(std::string(type) == "ball" ? 2 : 5)) : "");
    out_ += " axis='" + numbers(3, 1) + "'";
    if (below(3) == 0) out_ += " ref='" + (std::string(type) == "slide" ? to_text(in(-1, 1)) : angle(1)) + "'";
    if (below(3) == 0) out_ += " springref='" + to_text(in(-1, 1)) + "' stiffness='2'";
    if (below(3) == 0) out_ += " armature='0.02'";
    if (below(6) == 0) out_ += " springdamper='0.1 0.7'";
    out_ += "/>";
  }

  void body(int depth) {
    const std::string name = "b" + std::to_string(bodies_++);
    names_.push_back(name);
    out_ += "<body name='" + name + "' " + pose(1) + (below(3) == 0 ? " childclass='a'" : "") + ">";
    if (depth == 0 && below(2) == 0) {
      out_ += below(2) == 0 ? "<freejoint/>" : "<joint type='free' armature='0.1' stiffness='0' pos='1 2 3'/>";
    } else {
      for (int k = below(4); k > 0; --k) joint(below(2) == 0 ? "hinge" : "slide");
      if (below(4) == 0) joint("ball");
    }
    if (below(3) == 0) {
      out_ += "<inertial pos='" + numbers(3, 0.2) + "' mass='" + to_text(in(0.5, 3)) + "' ";
      if (below(2) == 0)
        out_ += "fullinertia='0.3 0.4 0.35 0.02 -0.03 0.01'/>";
      else
        out_ += orientation() + " diaginertia='0.2 " + to_text(in(0.15, 0.25)) + " 0.3'/>";
    }
    out_ += "<geom type='sphere' size='0.1' group='1' pos='" + numbers(3, 0.2) + "'/>";
    for (int k = below(3); k > 0; --k) geom();
    out_ += "<site name='s" + name + "' class='" + (below(2) == 0 ? "main" : "a") + "' " + pose(0.3) + "/>";
    if (depth < 3)
      for (int k = below(3); k > 0; --k) body(depth + 1);
    out_ += "</body>";
  }

  std::string equalities() {
    std::string out;
    const auto any = [&](const std::vector<std::string>& of) { return of[static_cast<std::size_t>(below(static_cast<int>(of.size())))]; };
    for (int k = below(4); k > 0; --k) {
      const std::string a = any(names_), b = any(names_);
      const std::string second = below(3) == 0 || a == b ? "" : " body2='" + b + "'";
      if (below(2) == 0)
        out += "<connect body1='" + a + "'" + second + " anchor='" + numbers(3, 0.3) + "'/>";
      else
        out += "<weld body1='" + a + "'" + second + (below(2) == 0 ? " relpose='" + numbers(7, 1) + "'" : "") +
               (below(2) == 0 ? " anchor='" + numbers(3, 0.3) + "'" : "") + "/>";
    }
    if (scalar_joints_.size() > 1)
      out += "<joint joint1='" + scalar_joints_[0] + "' joint2='" + scalar_joints_[1] + "' polycoef='" + numbers(5, 1) + "'/>";
    return out;
  }

  std::mt19937 random_;
  std::string out_;
  bool degrees_ = true;
  int bodies_ = 0, joints_ = 0;
  std::vector<std::string> names_, scalar_joints_;
};

}  // namespace ugoki::robot_formats
