#include "osc.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <optional>
#include <string_view>
#include <vector>

#include "ugoki/base/number.h"
#include "ugoki/base/printable.h"
#include "ugoki/json/json.h"

namespace ugoki::player_native {
namespace {

using json::Json;

constexpr int max_depth = 8;           // maximum depth of bundles inside bundles
constexpr std::size_t max_keys = 256;  // maximum number of keys pressed at the same time, more than any keyboard has

std::unexpected<Error> malformed(const char* what) {
  return fail(ErrorCode::syntax, "OSC packet", what, "Send messages of OSC 1.0; docs/export.md lists the addresses.");
}

/// Reads the parts of an OSC packet in order. Numbers are big-endian; texts are padded with zeros to multiples of 4 bytes.
class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : rest_(bytes) {}
  [[nodiscard]] bool empty() const { return rest_.empty(); }
  std::optional<std::string_view> text() {
    const auto* begin = reinterpret_cast<const char*>(rest_.data());
    const std::size_t size = std::string_view(begin, rest_.size()).find('\0');
    if (size == std::string_view::npos || !take(size / 4 * 4 + 4)) return std::nullopt;
    return std::string_view(begin, size);
  }
  std::optional<std::uint32_t> word() {
    if (rest_.size() < 4) return std::nullopt;
    std::uint32_t out = 0;
    for (std::size_t k = 0; k < 4; ++k) out = out << 8 | std::to_integer<std::uint32_t>(rest_[k]);
    take(4);
    return out;
  }
  std::optional<std::span<const std::byte>> bytes(std::size_t size) {
    const auto out = rest_;
    if (!take(size)) return std::nullopt;
    return out.first(size);
  }

 private:
  bool take(std::size_t size) {
    if (size > rest_.size()) return false;
    rest_ = rest_.subspan(size);
    return true;
  }
  std::span<const std::byte> rest_;
};

/// Reads the arguments of a message as numbers. @param types one OSC type tag for each argument, without the leading comma
Result<std::vector<double>> read_arguments(Reader& reader, std::string_view types) {
  std::vector<double> out;
  for (const char type : types) {
    double value = type == 'T' ? 1 : 0;
    if (type == 'i' || type == 'f') {
      const auto word = reader.word();
      if (!word) return malformed("The packet ends within an argument.");
      value = type == 'i' ? static_cast<double>(static_cast<std::int32_t>(*word)) : static_cast<double>(std::bit_cast<float>(*word));
    } else if (type == 'd' || type == 'h') {
      const auto high = reader.word(), low = reader.word();
      if (!high || !low) return malformed("The packet ends within an argument.");
      const std::uint64_t bits = static_cast<std::uint64_t>(*high) << 32 | *low;
      value = type == 'd' ? std::bit_cast<double>(bits) : static_cast<double>(static_cast<std::int64_t>(bits));
    } else if (type != 'T' && type != 'F') {
      return malformed("An argument is not a number.");
    }
    if (!std::isfinite(value)) return malformed("An argument is not finite.");
    out.push_back(value);
  }
  return out;
}

Result<void> apply_message(std::string_view address, const std::vector<double>& values, circuit::DeviceState& state) {
  const auto after = [&](std::string_view prefix) -> std::optional<std::string> {
    if (!address.starts_with(prefix)) return std::nullopt;
    return std::string(address.substr(prefix.size()));
  };
  const auto unknown = [&] {
    return fail(ErrorCode::unknown, "OSC message " + std::string(address.substr(0, 80)),
                "There is no such address, or the number of arguments is wrong.", "docs/export.md lists the addresses.");
  };
  if (address == "/ugoki/mouse" && values.size() == 2) {
    state.mouse.x = std::clamp(values[0], 0.0, 1.0);
    state.mouse.y = std::clamp(values[1], 0.0, 1.0);
    return {};
  }
  if (values.size() != 1) return unknown();
  const double value = values[0];
  if (const auto key = after("/ugoki/key/"); key && !key->empty() && key->size() <= 32) {
    const auto at = std::ranges::lower_bound(state.keys, *key);
    const bool pressed = at != state.keys.end() && *at == *key;
    if (value != 0 && !pressed && state.keys.size() < max_keys) state.keys.insert(at, *key);
    if (value == 0 && pressed) state.keys.erase(at);
    return {};
  }
  if (address == "/ugoki/mouse/left")
    state.mouse.left = value != 0;
  else if (address == "/ugoki/mouse/middle")
    state.mouse.middle = value != 0;
  else if (address == "/ugoki/mouse/right")
    state.mouse.right = value != 0;
  else if (address == "/ugoki/mouse/wheel")
    state.mouse.wheel += std::clamp(value, -100.0, 100.0);
  else {
    const auto pad_text = after("/ugoki/gamepad/");
    if (!pad_text) return unknown();
    const std::size_t slash = pad_text->find('/');
    const std::optional<long> pad = parse_long(pad_text->substr(0, slash));
    const std::string rest = slash == std::string::npos ? "" : pad_text->substr(slash + 1);
    const bool axis = rest.starts_with("axis/");
    if (!pad || *pad < 0 || *pad >= static_cast<long>(circuit::max_gamepads) || (!axis && !rest.starts_with("button/"))) return unknown();
    circuit::GamepadState& gamepad = state.gamepads[static_cast<std::size_t>(*pad)];
    const std::optional<long> index = parse_long(rest.substr(axis ? 5 : 7));
    if (!index || *index < 0 || *index >= static_cast<long>(axis ? gamepad.axes.size() : gamepad.buttons.size())) return unknown();
    (axis ? gamepad.axes[static_cast<std::size_t>(*index)] : gamepad.buttons[static_cast<std::size_t>(*index)]) =
        std::clamp(value, axis ? -1.0 : 0.0, 1.0);
  }
  return {};
}

Result<void> apply_part(std::span<const std::byte> packet, circuit::DeviceState& state, int depth) {
  Reader reader(packet);
  const auto address = reader.text();
  if (!address) return malformed("It begins with no address.");
  if (*address == "#bundle") {
    if (depth == 0) return malformed("Too many bundles are inside each other.");
    if (!reader.bytes(8)) return malformed("The bundle has no time tag.");
    while (!reader.empty()) {
      const auto size = reader.word();
      const auto part = size ? reader.bytes(*size) : std::nullopt;
      if (!part) return malformed("The bundle ends within an element.");
      if (Result<void> done = apply_part(*part, state, depth - 1); !done) return done;
    }
    return {};
  }
  const auto types = reader.text();
  if (!types || !types->starts_with(',')) return malformed("The message has no list of types.");
  const Result<std::vector<double>> values = read_arguments(reader, types->substr(1));
  if (!values) return fail(values.error());
  return apply_message(*address, *values, state);
}

/// Returns the state as the JSON message `input` of a page. @param wheel turns of the mouse wheel since the last message, notches
std::string input_json(const circuit::DeviceState& state, double wheel) {
  Json gamepads = Json::array();
  for (const circuit::GamepadState& g : state.gamepads)
    gamepads.push_back(g == circuit::GamepadState{} ? Json(nullptr) : Json{{"axes", g.axes}, {"buttons", g.buttons}});
  const circuit::MouseState& m = state.mouse;
  return json::to_text(
      Json{{"op", "input"},
           {"keyboard", state.keys},
           {"mouse", {{"x", m.x}, {"y", m.y}, {"left", m.left}, {"middle", m.middle}, {"right", m.right}, {"wheel", wheel}}},
           {"gamepads", std::move(gamepads)}});
}

}  // namespace

Result<void> apply_osc(std::span<const std::byte> packet, circuit::DeviceState& state) { return apply_part(packet, state, max_depth); }

Result<std::unique_ptr<OscReceiver>> OscReceiver::listen(std::uint16_t port, std::function<void(std::string)> changed) {
  std::unique_ptr<OscReceiver> out(new OscReceiver);
  out->changed_ = std::move(changed);
  out->socket_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(port);
  socklen_t size = sizeof address;
  auto* name = reinterpret_cast<sockaddr*>(&address);
  if (out->socket_ < 0 || ::bind(out->socket_, name, sizeof address) != 0 || ::getsockname(out->socket_, name, &size) != 0 ||
      ::pipe(out->wake_) != 0)
    return fail(ErrorCode::io, "--osc " + std::to_string(port), std::string("The UDP port cannot be opened: ") + std::strerror(errno) + ".",
                "Name another port, or 0 for any free port.");
  out->port_ = ntohs(address.sin_port);
  out->thread_ = std::thread([receiver = out.get()] { receiver->run(); });
  return out;
}

OscReceiver::~OscReceiver() {
  if (thread_.joinable()) {
    (void)!::write(wake_[1], "", 1);
    thread_.join();
  }
  for (const int file : {socket_, wake_[0], wake_[1]})
    if (file >= 0) ::close(file);
}

void OscReceiver::run() {
  circuit::DeviceState state;
  std::array<std::byte, 65536> packet;
  for (;;) {
    pollfd waits[] = {{socket_, POLLIN, 0}, {wake_[0], POLLIN, 0}};
    if (::poll(waits, 2, -1) < 0 && errno != EINTR) return;
    if (waits[1].revents != 0) return;
    const ssize_t size = ::recv(socket_, packet.data(), packet.size(), MSG_DONTWAIT);
    if (size < 0) continue;
    const circuit::DeviceState before = state;
    if (const Result<void> done = apply_osc(std::span(packet).first(static_cast<std::size_t>(size)), state); !done)
      std::fprintf(stderr, "%s\n", printable(done.error().text()).c_str());
    if (!(state == before)) changed_(input_json(state, state.mouse.wheel - before.mouse.wheel));
  }
}

}  // namespace ugoki::player_native
