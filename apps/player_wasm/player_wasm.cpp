// The WebAssembly exports of the player. One content is open at a time. Arguments and results are numbers, so that a page needs only a few
// lines of glue code.
//
//   ugoki_allocate(size) -> address, ugoki_release(address)   memory for the bytes to open and for states
//   ugoki_open(address, size) -> 1 opened, 0 refused          ugoki_message() is the reason
//   ugoki_step(n) -> steps done                               fewer than n: the run stopped, ugoki_message() is the reason
//   ugoki_time(), ugoki_step_size(), ugoki_duration(), ugoki_frame_rate()
//   ugoki_hash_low(), ugoki_hash_high()                       state hash
//   ugoki_frame(number, flags) -> address, ugoki_frame_size() a frame as in docs/studio-protocol.md
//   ugoki_push, ugoki_grab, ugoki_drag, ugoki_drop            inputs of the user; character and link indices as in the frame
//   ugoki_input(address, size) -> 1 accepted, 0 refused       keyboard, mouse and gamepads: the fields of `input` in that document, as JSON
//   ugoki_devices() -> address, ugoki_message_size()          devices that the content reads, as JSON: the fields of the event `devices`
//   ugoki_scene() -> address, ugoki_message_size()            JSON that a page draws before the first frame: content::scene_json()
//   ugoki_variables() -> address of doubles                  values of the variables of the scene, in its order
//   ugoki_schedule(address, size) -> 1 accepted, 0 refused    recorded inputs, as JSON (docs/export.md), to be applied after a reset
//   ugoki_inputs() -> address, ugoki_message_size()           inputs since the last reset, as JSON in the form of ugoki_schedule
//   ugoki_steps() -> number of steps since time 0; ugoki_reset() restarts; ugoki_message() -> address, ugoki_message_size(): UTF-8

#include <cstdint>
#include <cstdlib>
#include <optional>
#include <string>
#include <vector>

#include "ugoki/content/inputs.h"
#include "ugoki/content/mechanism_display.h"
#include "ugoki/content/player.h"

#define PLAYER_EXPORT(name) extern "C" __attribute__((export_name(#name), used))

namespace {

struct Session {
  std::optional<ugoki::content::Player> player;
  ugoki::content::DisplayFrame frame;
  ugoki::circuit::DeviceState held;
  std::vector<std::byte> bytes;
  std::vector<double> variables;
  std::string message;
};

Session& session() {
  static Session* one = new Session;  // never destroyed: lives as long as the module
  return *one;
}

}  // namespace

PLAYER_EXPORT(ugoki_allocate) void* ugoki_allocate(std::uint32_t size) { return std::malloc(size); }
PLAYER_EXPORT(ugoki_release) void ugoki_release(void* address) { std::free(address); }

PLAYER_EXPORT(ugoki_open) std::int32_t ugoki_open(const std::byte* bytes, std::uint32_t size) {
  Session& s = session();
  s.player.reset();
  s.message.clear();
  auto player = ugoki::content::Player::open({bytes, size});
  if (!player) {
    s.message = player.error().text();
    return 0;
  }
  s.player.emplace(std::move(*player));
  s.held.mouse.wheel = 0;
  s.player->hold(s.held);
  return 1;
}

PLAYER_EXPORT(ugoki_step) std::uint32_t ugoki_step(std::uint32_t count) {
  Session& s = session();
  if (!s.player) return 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    if (const auto done = s.player->step(); !done) {
      s.message = done.error().text();
      return i;
    }
  }
  return count;
}

PLAYER_EXPORT(ugoki_reset) void ugoki_reset() {
  Session& s = session();
  if (!s.player) return;
  s.player->reset();
  s.held.mouse.wheel = 0;
  s.player->hold(s.held);
}
PLAYER_EXPORT(ugoki_time) double ugoki_time() { return session().player ? session().player->time() : 0; }
PLAYER_EXPORT(ugoki_step_size) double ugoki_step_size() { return session().player ? session().player->step_size() : 0; }
PLAYER_EXPORT(ugoki_duration) double ugoki_duration() { return session().player ? session().player->content().duration : 0; }
PLAYER_EXPORT(ugoki_frame_rate) double ugoki_frame_rate() { return session().player ? session().player->content().frame_rate : 0; }

PLAYER_EXPORT(ugoki_hash_low) std::uint32_t ugoki_hash_low() {
  return session().player ? static_cast<std::uint32_t>(session().player->state_hash()) : 0;
}
PLAYER_EXPORT(ugoki_hash_high) std::uint32_t ugoki_hash_high() {
  return session().player ? static_cast<std::uint32_t>(session().player->state_hash() >> 32) : 0;
}

PLAYER_EXPORT(ugoki_frame) const std::byte* ugoki_frame(std::uint32_t number, std::uint32_t flags) {
  Session& s = session();
  if (!s.player) return nullptr;
  s.player->display_frame(s.frame);
  ugoki::content::encode_frame(s.frame, number, flags, s.bytes);
  return s.bytes.data();
}
PLAYER_EXPORT(ugoki_frame_size) std::uint32_t ugoki_frame_size() { return static_cast<std::uint32_t>(session().bytes.size()); }

PLAYER_EXPORT(ugoki_push) void ugoki_push(std::int32_t character, std::int32_t link, double x, double y, double z, double duration) {
  if (session().player) session().player->push(character, link, {x, y, z}, duration);
}
PLAYER_EXPORT(ugoki_grab)
void ugoki_grab(std::int32_t character, std::int32_t link, double px, double py, double pz, double tx, double ty, double tz) {
  if (session().player) session().player->grab(character, link, {px, py, pz}, {tx, ty, tz});
}
PLAYER_EXPORT(ugoki_drag) void ugoki_drag(double x, double y, double z) {
  if (session().player) session().player->drag({x, y, z});
}
PLAYER_EXPORT(ugoki_drop) void ugoki_drop() {
  if (session().player) session().player->release();
}

PLAYER_EXPORT(ugoki_input) std::int32_t take_input(const char* json, std::uint32_t size) {
  Session& s = session();
  const auto change = ugoki::circuit::read_device_change({json, size});
  if (!change) {
    s.message = change.error().text();
    return 0;
  }
  ugoki::circuit::apply(*change, s.held);
  if (s.player) s.player->hold(s.held);
  return 1;
}
PLAYER_EXPORT(ugoki_devices) const char* ugoki_devices() {
  Session& s = session();
  s.message = ugoki::circuit::write_device_use(s.player ? s.player->devices().use() : ugoki::circuit::DeviceUse{});
  return s.message.data();
}

PLAYER_EXPORT(ugoki_scene) const char* ugoki_scene() {
  Session& s = session();
  s.message = s.player ? ugoki::content::scene_json(s.player->content()) : "{}";
  return s.message.data();
}

PLAYER_EXPORT(ugoki_variables) const double* ugoki_variables() {
  Session& s = session();
  if (s.player) s.player->variable_values(s.variables);
  return s.variables.data();
}

PLAYER_EXPORT(ugoki_schedule) std::int32_t ugoki_schedule(const char* json, std::uint32_t size) {
  Session& s = session();
  if (!s.player) return 0;
  auto inputs = ugoki::content::read_inputs({json, size}, s.player->content(), "inputs");
  if (!inputs) {
    s.message = inputs.error().text();
    return 0;
  }
  s.player->schedule(std::move(*inputs));
  return 1;
}
PLAYER_EXPORT(ugoki_inputs) const char* ugoki_inputs() {
  Session& s = session();
  s.message = s.player ? ugoki::content::write_inputs(s.player->inputs(), s.player->content()) : "{}";
  return s.message.data();
}
PLAYER_EXPORT(ugoki_steps) double ugoki_steps() { return session().player ? static_cast<double>(session().player->step_count()) : 0; }

PLAYER_EXPORT(ugoki_message) const char* ugoki_message() { return session().message.data(); }
PLAYER_EXPORT(ugoki_message_size) std::uint32_t ugoki_message_size() { return static_cast<std::uint32_t>(session().message.size()); }
