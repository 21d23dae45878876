#pragma once
// OpenSim models (.osim, versions 2 to 4): bodies, joints with their coordinates and functions, and their kinematics.
//
// A joint connects a frame F of the parent body with a frame M of its own body:
//   X_FM(q) = [R1(f1) R2(f2) R3(f3), f4 a4 + f5 a5 + f6 a6],
// where R_i is the rotation about the axis a_i, and each f_i is a function of the joint's coordinates (Seth et al. 2010).

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/mechanism/joint.h"
#include "ugoki/robot_formats/xml_fields.h"

namespace ugoki::robot_formats {

/// Function of one coordinate, or a linear function of several coordinates.
struct OsimFunction {
  enum class Kind { linear, polynomial, lines, spline } kind = Kind::linear;
  std::vector<double> a = {0};  ///< linear: slopes, then the constant; polynomial: highest power first; lines, spline: knots x
  std::vector<double> y = {};   ///< lines, spline: values at the knots
  std::vector<double> m = {};   ///< spline: second derivatives at the knots
  double scale = 1;             ///< factor of the value

  /// Value for the coordinates x. Outside its knots, a spline continues along its end tangents.
  [[nodiscard]] double operator()(std::span<const double> x) const;
};

struct OsimCoordinate {
  std::string name;
  double rest = 0;              ///< default value, rad or m
  double lower = 0, upper = 0;  ///< range, rad or m; lower == upper: none
  bool locked = false;          ///< constant at its default value
  bool rotational = false;      ///< an angle
  int source = -1;              ///< coordinate that determines this one (CoordinateCouplerConstraint); -1: independent
  OsimFunction coupling;        ///< value from the source
};

/// Rotation about, or translation along, an axis fixed in F.
struct OsimAxis {
  Vec3 axis;                     ///< unit
  std::vector<int> coordinates;  ///< indices in OsimModel::coordinates, the arguments of the function
  OsimFunction function;
};

struct OsimBody {
  std::string name;
  pugi::xml_node node;
  Inertia inertia;                 ///< in the body's frame
  int parent = -1;                 ///< body; -1: ground
  std::string joint;               ///< name of its joint; empty: none
  Pose X_PF, X_BM;                 ///< F in the parent body's frame, M in the body's frame
  std::array<OsimAxis, 6> motion;  ///< three rotations, three translations
  std::vector<int> coordinates;    ///< the joint's coordinates
  struct Sphere {
    Vec3 centre;        ///< m, in the body's frame
    double radius = 0;  ///< m
  };
  std::vector<Sphere> contacts;  ///< contact spheres
};

struct OsimModel {
  std::string name;
  std::vector<OsimBody> bodies;  ///< parents first
  std::vector<OsimCoordinate> coordinates;
  Mat3 to_world = Mat3::identity();  ///< rotation from the file's ground axes to Z up, from the direction of gravity

  /// Values of all coordinates from those of the independent ones: locked coordinates get their default, coupled ones follow their source.
  void complete(std::vector<double>& q) const;
  /// X_FM of a body's joint. @param q [coordinates]
  [[nodiscard]] Pose joint_pose(const OsimBody& body, std::span<const double> q) const;
  /// Index of the coordinate; -1: none. O(coordinates)
  [[nodiscard]] int find_coordinate(std::string_view wanted) const;
};

/// Reads a model from parsed XML. Returns false if problems were added to `xml`.
[[nodiscard]] bool read_osim_model(XmlFields& xml, OsimModel& model);

/// A joint of the types of joint.h that moves like the joint of a body, as nearly as possible.
struct OsimJointFit {
  /// One link of a chain: the last link is the body, the others have no mass. q[i] = value of the axis `axes[i]` of OsimBody::motion.
  struct Step {
    Joint joint;            ///< X_PJ: in F for the first step, otherwise in the previous step's link frame
    std::vector<int> axes;  ///< motion axis of each coordinate of the joint, in its order
  };
  std::vector<Step> chain;
  Pose X_LM;             ///< M in the frame of the last link
  double deviation = 0;  ///< m, maximum distance of M's origin from its true position over the ranges of the coordinates
  double turn = 0;       ///< rad, maximum angle of the same kind
};
[[nodiscard]] OsimJointFit fit_joint(const OsimModel& model, const OsimBody& body);

/// Coordinates of one step of the chain. @param q [OsimModel::coordinates], complete @param out [>= nq of the joint]
void osim_joint_coordinates(const OsimBody& body, const OsimJointFit::Step& step, std::span<const double> q, std::span<double> out);

}  // namespace ugoki::robot_formats
