#include "ugoki/content/film.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "ugoki/base/number.h"
#include "ugoki/content/film_json.h"
#include "ugoki/content/scenario.h"

namespace ugoki::content {
namespace {

constexpr double day = 86400;             // s: upper limit of times
constexpr std::size_t max_items = 1'000;  // maximum number of cameras, of shots, and of keys of one camera

using Values = std::array<double, 7>;

Values values_of(const FilmView& v) { return {v.target.x, v.target.y, v.target.z, v.azimuth, v.elevation, v.distance, v.field_of_view}; }

/// Monotone slope at a key between two spans of durations h0, h1 with mean slopes d0, d1 (Fritsch and Butland 1984).
double slope_between(double h0, double h1, double d0, double d1) {
  if (!(d0 * d1 > 0)) return 0;
  const double w0 = 2 * h1 + h0, w1 = h1 + 2 * h0;
  return (w0 + w1) / (w0 / d0 + w1 / d1);
}

void read_view(Fields& f, FilmView& out) {
  f.vec3("target", out.target);
  f.number("azimuth", out.azimuth);
  f.number("elevation", out.elevation);
  f.number("distance", out.distance);
  f.number("field_of_view", out.field_of_view);
}

void write_view(const FilmView& view, Json& json) {
  json["target"] = to_json(view.target);
  json["azimuth"] = view.azimuth;
  json["elevation"] = view.elevation;
  json["distance"] = view.distance;
  json["field_of_view"] = view.field_of_view;
}

/// Calls read(fields) with each object of the list `key`.
template <class Read>
void read_items(Fields& f, std::string_view key, Read read) {
  const Json* list = f.list(key, max_items, key);
  if (!list) return;
  for (std::size_t i = 0; i < list->size(); ++i) {
    Fields g((*list)[i], f.path(key) + "/" + std::to_string(i), f.problems());
    read(g);
    g.refuse_others();
  }
}

void check_range(const std::string& location, double value, double low, double high, std::string_view unit, Error& problems) {
  if (value >= low && value <= high) return;
  problems.add(ErrorCode::range, location, "The value " + ugoki::to_text(value) + " is out of range.",
               "Give a value from " + ugoki::to_text(low) + " to " + ugoki::to_text(high) + " " + std::string(unit) + ".");
}

void check_view(const FilmView& v, const std::string& location, Error& problems) {
  for (int i = 0; i < 3; ++i) check_range(location + "/target", v.target[i], -10000, 10000, "m", problems);
  check_range(location + "/azimuth", v.azimuth, -1000, 1000, "rad", problems);
  check_range(location + "/elevation", v.elevation, -1.56, 1.56, "rad", problems);
  check_range(location + "/distance", v.distance, 0.05, 1000, "m", problems);
  check_range(location + "/field_of_view", v.field_of_view, 0.02, 2.5, "rad", problems);
}

}  // namespace

FilmView view_of(const FilmCamera& camera, double time) {
  const std::vector<FilmKey>& keys = camera.keys;
  if (keys.empty()) return camera.view;
  const auto next = std::upper_bound(keys.begin(), keys.end(), time, [](double t, const FilmKey& key) { return t < key.time; });
  if (next == keys.begin()) return keys.front().view;
  if (next == keys.end()) return keys.back().view;
  const std::size_t i = static_cast<std::size_t>(next - keys.begin()) - 1;
  const double h = keys[i + 1].time - keys[i].time, x = (time - keys[i].time) / h;
  const auto slope = [&](std::size_t k, std::size_t value) {
    if (k == 0 || k + 1 == keys.size()) return 0.0;
    const double h0 = keys[k].time - keys[k - 1].time, h1 = keys[k + 1].time - keys[k].time;
    const double v = values_of(keys[k].view)[value];
    return slope_between(h0, h1, (v - values_of(keys[k - 1].view)[value]) / h0, (values_of(keys[k + 1].view)[value] - v) / h1);
  };
  const double rest = 1 - x, s = x * x * (3 - 2 * x);
  const Values from = values_of(keys[i].view), to = values_of(keys[i + 1].view);
  Values out;
  for (std::size_t k = 0; k < out.size(); ++k)
    out[k] = from[k] + s * (to[k] - from[k]) + h * x * rest * (rest * slope(i, k) - x * slope(i + 1, k));
  return {{out[0], out[1], out[2]}, out[3], out[4], out[5], out[6]};
}

const FilmShot* shot_at(const std::vector<FilmShot>& shots, double time) {
  const FilmShot* found = nullptr;
  for (const FilmShot& shot : shots)
    if (shot.start <= time && time < shot.start + shot.length) found = &shot;
  return found;
}

void put_in_order(std::vector<FilmCamera>& cameras, std::vector<FilmShot>& shots) {
  for (FilmCamera& camera : cameras)
    std::sort(camera.keys.begin(), camera.keys.end(), [](const FilmKey& a, const FilmKey& b) { return a.time < b.time; });
  std::sort(shots.begin(), shots.end(),
            [](const FilmShot& a, const FilmShot& b) { return a.start != b.start ? a.start < b.start : a.id < b.id; });
}

void read_camera(Fields& f, FilmCamera& out) {
  f.text("id", out.id);
  f.text("name", out.name);
  if (const Json* follow = f.find("follow"); follow && follow->is_null())
    out.follow.clear();
  else
    f.text("follow", out.follow);
  read_view(f, out.view);
  if (f.has("keys")) out.keys.clear();
  read_items(f, "keys", [&](Fields& g) {
    FilmKey& key = out.keys.emplace_back();
    key.view = out.view;
    g.require("time", "its time in seconds");
    g.number("time", key.time);
    read_view(g, key.view);
  });
}

void read_shot(Fields& f, FilmShot& out) {
  f.text("id", out.id);
  f.text("camera", out.camera);
  f.number("start", out.start);
  f.number("length", out.length);
}

void read_film(Fields& f, Scenario& out) {
  read_items(f, "cameras", [&](Fields& g) { read_camera(g, out.cameras.emplace_back()); });
  read_items(f, "shots", [&](Fields& g) { read_shot(g, out.shots.emplace_back()); });
}

void write_film(const std::vector<FilmCamera>& cameras, const std::vector<FilmShot>& shots, Json& json) {
  for (const FilmCamera& c : cameras) {
    Json camera;
    camera["id"] = c.id;
    camera["name"] = c.name;
    if (!c.follow.empty()) camera["follow"] = c.follow;
    write_view(c.view, camera);
    for (const FilmKey& k : c.keys) {
      Json key;
      key["time"] = k.time;
      write_view(k.view, key);
      camera["keys"].push_back(std::move(key));
    }
    json["cameras"].push_back(std::move(camera));
  }
  for (const FilmShot& s : shots) {
    Json shot;
    shot["id"] = s.id;
    shot["camera"] = s.camera;
    shot["start"] = s.start;
    shot["length"] = s.length;
    json["shots"].push_back(std::move(shot));
  }
}

void check_film(const Scenario& s, const Scenario& flat, const std::string& root, Error& problems) {
  for (std::size_t i = 0; i < s.cameras.size(); ++i) {
    const FilmCamera& c = s.cameras[i];
    const std::string location = root + "/cameras/" + std::to_string(i);
    if (c.name.empty() || c.name.size() > 200)
      problems.add(ErrorCode::range, location + "/name", "The name is empty or longer than 200 bytes.", "Give it a short name.");
    if (!c.follow.empty() && !flat.find_character(c.follow))
      problems.add(ErrorCode::unknown, location + "/follow", "There is no character '" + c.follow + "'.",
                   "Name a character of the document, or remove this reference.");
    check_view(c.view, location, problems);
    for (std::size_t k = 0; k < c.keys.size(); ++k) {
      const std::string key = location + "/keys/" + std::to_string(k);
      check_range(key + "/time", c.keys[k].time, 0, day, "s", problems);
      check_view(c.keys[k].view, key, problems);
      if (k > 0 && c.keys[k].time - c.keys[k - 1].time < 1e-4)
        problems.add(ErrorCode::structure, key + "/time", "Two keys of the camera are less than 0.1 ms apart.", "Remove one of them.");
    }
  }
  for (std::size_t i = 0; i < s.shots.size(); ++i) {
    const FilmShot& shot = s.shots[i];
    const std::string location = root + "/shots/" + std::to_string(i);
    check_range(location + "/start", shot.start, 0, day, "s", problems);
    check_range(location + "/length", shot.length, 0.001, day, "s", problems);
    if (std::none_of(s.cameras.begin(), s.cameras.end(), [&](const FilmCamera& c) { return c.id == shot.camera; }))
      problems.add(ErrorCode::unknown, location + "/camera", "There is no camera '" + shot.camera + "'.", "Name a camera of the document.");
    if (i > 0 && !(shot.start > s.shots[i - 1].start))
      problems.add(ErrorCode::structure, location + "/start",
                   "Shots '" + s.shots[i - 1].id + "' and '" + shot.id + "' start at the same time.", "Move one of them.");
  }
}

void remove_camera(Scenario& s, const std::string& id) {
  std::erase_if(s.shots, [&](const FilmShot& shot) { return shot.camera == id; });
  std::erase_if(s.cameras, [&](const FilmCamera& camera) { return camera.id == id; });
}

}  // namespace ugoki::content
