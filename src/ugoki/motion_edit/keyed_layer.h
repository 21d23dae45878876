#pragma once
// Keyed layers: keys of single joints, set by hand, that change a motion. A layer adds to the motion or replaces it.

#include <array>
#include <span>
#include <string>
#include <vector>

#include "ugoki/motion/motion.h"

namespace ugoki::motion_edit {

/// How a curve passes through a key.
enum class Tangent {
  smooth,  ///< slope computed from the neighbouring keys; values stay between those of the two keys around them
  linear,  ///< straight lines to the neighbouring keys
  step,    ///< the value is constant until the next key
  free     ///< slopes set by the user
};

/// Value of a joint at one time. Unused components are 0.
struct LayerKey {
  double time = 0;  ///< s, time in the motion
  std::array<double, 3>
      value{};  ///< rad | m: displacement from the neutral position (see JointPart), or in additive layers from the motion
  Tangent tangent = Tangent::smooth;
  std::array<double, 3> slope_in{}, slope_out{};  ///< rad/s | m/s, slopes before and after the key; used only with Tangent::free
  friend bool operator==(const LayerKey&, const LayerKey&) = default;
};

/// The part of a joint that a curve moves: the whole joint, or of a floating joint its rotation or its position.
enum class JointPart { whole, rotation, position };

/// The keys of one joint, or of one part of a floating joint.
struct JointKeys {
  std::string link;  ///< name of the link that the joint moves
  JointPart part = JointPart::whole;
  int components = 3;          ///< number of components of each value, see component_count()
  std::vector<LayerKey> keys;  ///< sorted by time; at least one
  friend bool operator==(const JointKeys&, const JointKeys&) = default;
};

enum class LayerMode { additive, replace };

struct KeyedLayer {
  LayerMode mode = LayerMode::additive;
  double weight = 1;     ///< 0 to 1
  double ease_in = -1;   ///< s before the first key in which the layer fades in; negative: the layer acts from the start of the motion
  double ease_out = -1;  ///< s after the last key in which the layer fades out; negative: the layer acts to the end of the motion
  std::vector<JointKeys> joints;  ///< sorted by link and part
  friend bool operator==(const KeyedLayer&, const KeyedLayer&) = default;

  /// Weight of the layer at time t [s], with its fades; 0 for a layer without keys. @param period see LayerMoment
  [[nodiscard]] double weight_at(double t, double period = 0) const;
  /// The keys of this joint; null: there are none.
  [[nodiscard]] const JointKeys* find(std::string_view link, JointPart part) const;
};

/// Keys of one curve nearer than this time are the same key, s. It is far below the period of the fastest frame rate, 1/120 s.
inline constexpr double min_key_distance = 5e-4;

/// Number of components of a key's value for this part of a joint: 1 to 3; 0 if the joint has no such part.
[[nodiscard]] int component_count(JointType type, JointPart part);

/// Slopes just before and just after each key: [keys][in, out][3]. Smooth keys: monotone slopes of Fritsch and Butland (1984), 0 at both
/// ends and where the curve turns. O(keys)
[[nodiscard]] std::vector<std::array<std::array<double, 3>, 2>> slopes_of(std::span<const LayerKey> keys);
/// Value of a curve at time t [s]: cubic Hermite interpolation, constant before the first and after the last key. O(keys)
[[nodiscard]] std::array<double, 3> value_at(std::span<const LayerKey> keys, double t);

/// State of a layer at one time: its weight, and where its curves are read: value_at(from) (1 - mix) + value_at(to) mix.
///
/// In a motion that repeats with a period [s], the fades continue across the end of the motion, so that it has no jump. Fades that do not
/// fit between the last key and the first key of the next round are shortened. Without a fade on one side, the other fade takes this time.
/// Without both, the curves lead from their last to their first key.
struct LayerMoment {
  double weight = 0, from = 0, to = 0, mix = 0;
};
/// @param period s, after which the motion repeats; 0: it does not repeat
[[nodiscard]] LayerMoment moment_of(const KeyedLayer& layer, double t, double period);

/// Applies one layer to the coordinates of a motion at time t [s]. Links that the mechanism does not have are ignored. @param q [nq]
/// @param period see LayerMoment
void apply_layer(const Mechanism& mechanism, const KeyedLayer& layer, double t, std::span<double> q, double period = 0);
/// Inverse of apply_layer(): the coordinates below the layer from those above it. @param q [nq, in and out]
/// @return false, and q is unchanged at these joints, if the layer replaces a joint completely
bool remove_layer(const Mechanism& mechanism, const KeyedLayer& layer, double t, std::span<double> q, double period = 0);

/// Value of a key that leads one part of a joint from `below` to `wanted`, if the layer has this weight (above 0).
/// @param below, wanted [nq] coordinates of the joint under the layer and those that the layer shall give
[[nodiscard]] std::array<double, 3> key_value(const Joint& joint, JointPart part, LayerMode mode, double weight, const double* below,
                                              const double* wanted);

/// Returns the motion with the layers applied, the first one first. @param repeats true: the motion is cyclic and is played in a loop; it
/// stays cyclic
/// Errors: the motion does not fit the mechanism; a link, part or time that does not exist.
/// O(frames * keyed joints)
[[nodiscard]] Result<Motion> apply_layers(const Mechanism& mechanism, const Motion& motion, std::span<const KeyedLayer> layers,
                                          bool repeats = false);

}  // namespace ugoki::motion_edit
