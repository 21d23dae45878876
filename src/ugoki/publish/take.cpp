#include "ugoki/publish/take.h"

#include <algorithm>
#include <cmath>

#include "ugoki/formats/bvh.h"
#include "ugoki/motion_edit/to_measured.h"
#include "ugoki/publish/number_text.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::publish {

Result<Take> record_take(content::Player& player, double duration, double rate, const TakeProgress& progress) {
  const content::Executable& content = player.content();
  Take take;
  take.name = content.name;
  take.rate = rate;
  take.gravity = content.gravity;
  take.camera = content.camera;
  for (const content::ExecutableCharacter& c : content.characters)
    take.characters.push_back({c.id, c.name, c.color, c.material.shape_colors, c.material.shown, content.mechanism_of(c), {}, {}, {}});
  const double step = player.step_size(), begin = player.time();
  const int frames = static_cast<int>(std::floor((duration - begin) * rate + 1e-6)) + 1;
  content::DisplayFrame frame;
  for (int f = 0; f < frames; ++f) {
    const auto until = static_cast<std::uint64_t>(std::llround((begin + f / rate) / step));
    while (player.step_count() < until)
      if (Result<void> good = player.step(); !good) return fail(std::move(good.error()));
    player.display_frame(frame);
    for (std::size_t i = 0; i < take.characters.size(); ++i) {
      TakeCharacter& c = take.characters[i];
      const content::DisplayCharacter& shown = frame.characters[i];
      c.poses.insert(c.poses.end(), shown.links.begin(), shown.links.end());
      c.centres.push_back(shown.centre_of_mass);
      const std::span<const double> q = player.q(static_cast<int>(i));
      c.q.insert(c.q.end(), q.begin(), q.end());
    }
    ++take.frames;
    if (progress && !progress(static_cast<double>(f + 1) / frames))
      return fail(ErrorCode::conflict, content.name, "The export was cancelled.", "Start the export again.");
  }
  return take;
}

TakeView view_at(const Take& take, int frame) {
  const auto followed =
      std::find_if(take.characters.begin(), take.characters.end(), [&](const TakeCharacter& c) { return c.id == take.camera.follow; });
  Vec3 target = {0, 0, 0.9};
  if (followed != take.characters.end() && take.frames > 0) {
    // The camera follows the mean over half a second around the frame. A camera that follows every step of a walk shakes.
    const int reach = static_cast<int>(std::lround(0.25 * take.rate));
    const int low = std::max(0, frame - reach), high = std::min(take.frames - 1, frame + reach);
    Vec3 sum;
    for (int f = low; f <= high; ++f) sum = sum + followed->centres[static_cast<std::size_t>(f)];
    target = sum / static_cast<double>(high - low + 1);
  } else if (!take.characters.empty() && take.frames > 0) {
    Vec3 sum;
    for (const TakeCharacter& c : take.characters) sum = sum + c.centres.front();
    target = sum / static_cast<double>(take.characters.size());
  }
  const SinCos a = sin_cos(take.camera.azimuth), e = sin_cos(take.camera.elevation);
  TakeView view;
  view.back = {e.cos * a.cos, e.cos * a.sin, e.sin};
  view.right = {-a.sin, a.cos, 0};
  view.up = cross(view.back, view.right);
  view.position = target + view.back * take.camera.distance;
  return view;
}

Result<const TakeCharacter*> find_character(const Take& take, std::string_view character) {
  for (const TakeCharacter& c : take.characters)
    if (character.empty() ? c.links() > 0 : c.id == character || c.name == character) return &c;
  return fail(ErrorCode::unknown, "character '" + std::string(character) + "'", "The content has no such character.",
              "`ugoki info` lists the characters.");
}

Result<std::string> write_take_bvh(const Take& take, std::string_view character) {
  const Result<const TakeCharacter*> chosen = find_character(take, character);
  if (!chosen) return fail(chosen.error());
  const TakeCharacter& c = **chosen;
  Motion motion;
  motion.name = c.name;
  motion.source = take.name;
  motion.mechanism = c.mechanism->name();
  motion.rate = take.rate;
  motion.frames = take.frames;
  motion.nq = c.mechanism->nq();
  motion.q = c.q;
  return formats::write_bvh(motion_edit::to_measured(*c.mechanism, motion), {.metres_per_unit = 0.01});
}

std::string write_take_csv(const Take& take) {
  std::string out = "time";
  const auto quoted = [](const std::string& name) {
    if (name.find_first_of(",\"\n\r") == std::string::npos) return name;
    std::string text = "\"";
    for (const char c : name) text += c == '"' ? std::string("\"\"") : std::string(1, c);
    return text + '"';
  };
  for (const TakeCharacter& c : take.characters) {
    for (const char* axis : {" x", " y", " z"}) out += ',' + quoted(c.id + "/centre of mass" + axis);
    for (const Link& link : c.mechanism->links())
      for (const char* value : {" x", " y", " z", " qw", " qx", " qy", " qz"}) out += ',' + quoted(c.id + '/' + link.name + value);
  }
  out += '\n';
  const auto add = [&](double x) {
    out += ',';
    add_number(out, x);
  };
  for (int f = 0; f < take.frames; ++f) {
    add_number(out, f / take.rate);
    for (const TakeCharacter& c : take.characters) {
      const Vec3& centre = c.centres[static_cast<std::size_t>(f)];
      for (int k = 0; k < 3; ++k) add(centre[k]);
      for (std::size_t l = 0; l < c.links(); ++l) {
        const content::DisplayPose& x = c.pose(f, l);
        for (const double value : {x.p.x, x.p.y, x.p.z, x.r.w, x.r.x, x.r.y, x.r.z}) add(value);
      }
    }
    out += '\n';
  }
  return out;
}

}  // namespace ugoki::publish
