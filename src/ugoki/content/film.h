#pragma once
// Cameras of a scenario and the shots that they take. docs/scenario.md describes the JSON form. Cameras have no effect on the motion.

#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/spatial/vec3.h"

namespace ugoki::content {

class Fields;
struct Scenario;

/// Position and direction of a camera. It is at target + distance * (cos e cos a, cos e sin a, sin e) with azimuth a and elevation e, and
/// looks at the target; z is up.
struct FilmView {
  Vec3 target = {0, 0, 0.9};               ///< m, world; x and y from the centre of mass of the followed character, if there is one
  double azimuth = 0.7, elevation = 0.25;  ///< rad
  double distance = 5;                     ///< m, from the target
  double field_of_view = 0.62831853;       ///< rad, vertical angle of view in a picture of 16:9
  friend bool operator==(const FilmView&, const FilmView&) = default;
};

struct FilmKey {
  double time = 0;  ///< s, in the scenario
  FilmView view;
  friend bool operator==(const FilmKey&, const FilmKey&) = default;
};

struct FilmCamera {
  std::string id, name;
  std::string follow;         ///< id of the character that the camera follows; empty: none
  FilmView view;              ///< without keys
  std::vector<FilmKey> keys;  ///< sorted by time
  friend bool operator==(const FilmCamera&, const FilmCamera&) = default;
};

/// A time span of the camera track.
struct FilmShot {
  std::string id;
  std::string camera;            ///< id of a camera
  double start = 0, length = 1;  ///< s
  friend bool operator==(const FilmShot&, const FilmShot&) = default;
};

/// View of a camera at a time [s]. Between two keys every value is a monotone cubic: it does not exceed the values of the keys, and is at
/// rest at the first key, at the last key, and at every key that is a maximum or minimum (Fritsch and Butland 1984).
[[nodiscard]] FilmView view_of(const FilmCamera& camera, double time);

/// The shot at a time [s]: of the shots that include the time, the one that starts last; null: none.
[[nodiscard]] const FilmShot* shot_at(const std::vector<FilmShot>& shots, double time);

/// Sorts shots by start, and keys by time.
void put_in_order(std::vector<FilmCamera>& cameras, std::vector<FilmShot>& shots);

// Each of these functions reads one JSON object into `out`. Absent fields keep their value in `out`; a given list of keys replaces the old
// one. Internal to content.
void read_camera(Fields& fields, FilmCamera& out);
void read_shot(Fields& fields, FilmShot& out);

/// Adds the problems of the values of cameras and shots, and of the ids to which they refer. @param flat the flattened scenario, which has
/// the characters that cameras follow @param root location of the document
void check_film(const Scenario& scenario, const Scenario& flat, const std::string& root, Error& problems);

/// Removes a camera and its shots.
void remove_camera(Scenario& scenario, const std::string& id);

}  // namespace ugoki::content
