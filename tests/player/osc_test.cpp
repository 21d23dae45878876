// OSC packets that a native program receives: addresses, bundles, and truncated or random packets.

#include "../../apps/player_native/osc.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <bit>
#include <condition_variable>
#include <cstring>
#include <mutex>
#include <random>

namespace ugoki::player_native {
namespace {

using Packet = std::vector<std::byte>;

void add_text(Packet& p, std::string_view text) {
  for (const char c : text) p.push_back(static_cast<std::byte>(c));
  do p.push_back(std::byte{0});
  while (p.size() % 4 != 0);
}
void add_word(Packet& p, std::uint32_t word) {
  for (int shift = 24; shift >= 0; shift -= 8) p.push_back(static_cast<std::byte>(word >> shift));
}
Packet message(std::string_view address, std::initializer_list<float> values) {
  Packet p;
  add_text(p, address);
  add_text(p, "," + std::string(values.size(), 'f'));
  for (const float x : values) add_word(p, std::bit_cast<std::uint32_t>(x));
  return p;
}
Packet bundle(std::initializer_list<Packet> parts) {
  Packet p;
  add_text(p, "#bundle");
  add_word(p, 0);
  add_word(p, 1);
  for (const Packet& part : parts) {
    add_word(p, static_cast<std::uint32_t>(part.size()));
    p.insert(p.end(), part.begin(), part.end());
  }
  return p;
}

TEST(Osc, MessagesSetTheDevices) {
  circuit::DeviceState s;
  ASSERT_TRUE(apply_osc(message("/ugoki/key/KeyW", {1}), s));
  ASSERT_TRUE(apply_osc(message("/ugoki/key/KeyA", {1}), s));
  EXPECT_EQ(s.keys, (std::vector<std::string>{"KeyA", "KeyW"}));
  ASSERT_TRUE(apply_osc(message("/ugoki/key/KeyW", {0}), s));
  EXPECT_EQ(s.keys, (std::vector<std::string>{"KeyA"}));
  ASSERT_TRUE(apply_osc(bundle({message("/ugoki/mouse", {0.25F, 2}), bundle({message("/ugoki/mouse/left", {1})}),
                                message("/ugoki/gamepad/3/axis/2", {-0.5F}), message("/ugoki/gamepad/0/button/16", {1})}),
                        s));
  EXPECT_EQ(s.mouse.x, 0.25);
  EXPECT_EQ(s.mouse.y, 1) << "clamped";
  EXPECT_TRUE(s.mouse.left);
  EXPECT_EQ(s.gamepads[3].axes[2], -0.5);
  EXPECT_EQ(s.gamepads[0].buttons[16], 1);
}

TEST(Osc, ReadsAllTypesOfNumbers) {
  circuit::DeviceState s;
  Packet p;
  add_text(p, "/ugoki/mouse");
  add_text(p, ",dT");
  const auto bits = std::bit_cast<std::uint64_t>(0.5);
  add_word(p, static_cast<std::uint32_t>(bits >> 32));
  add_word(p, static_cast<std::uint32_t>(bits));
  ASSERT_TRUE(apply_osc(p, s));
  EXPECT_EQ(s.mouse.x, 0.5);
  EXPECT_EQ(s.mouse.y, 1);
}

TEST(Osc, RefusesOtherAddressesAndArguments) {
  circuit::DeviceState s;
  for (const Packet& p : {message("/other", {1}), message("/ugoki/key/", {1}), message("/ugoki/key/KeyW", {}), message("/ugoki/mouse", {1}),
                          message("/ugoki/gamepad/4/axis/0", {1}), message("/ugoki/gamepad/0/axis/4", {1}),
                          message("/ugoki/gamepad/0/axis/-1", {1}), message("/ugoki/key/KeyW", {NAN})})
    EXPECT_FALSE(apply_osc(p, s));
  EXPECT_EQ(s, circuit::DeviceState{});
}

TEST(Osc, CutAndRandomPacketsAreRefused) {
  const Packet whole = bundle({message("/ugoki/mouse", {0.25F, 0.5F}), message("/ugoki/key/KeyW", {1})});
  for (std::size_t size = 0; size < whole.size(); ++size) {
    circuit::DeviceState s;
    const Packet part(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));  // a copy: sanitizers see reads past its end
    (void)apply_osc(part, s);
  }
  std::mt19937_64 random(3);
  for (int i = 0; i < 20'000; ++i) {
    Packet p = whole;
    for (int k = 0; k < 4; ++k) p[random() % p.size()] = static_cast<std::byte>(random());
    circuit::DeviceState s;
    (void)apply_osc(p, s);
    EXPECT_LE(s.keys.size(), 1u);
  }
  Packet deep = message("/ugoki/mouse", {0, 0});
  for (int i = 0; i < 9; ++i) deep = bundle({deep});
  circuit::DeviceState s;
  EXPECT_FALSE(apply_osc(deep, s));
}

TEST(Osc, ReceiverTakesPacketsOfThisComputer) {
  std::mutex mutex;
  std::condition_variable arrived;
  std::string last;
  const auto receiver = OscReceiver::listen(0, [&](std::string text) {
    const std::lock_guard lock(mutex);
    last = std::move(text);
    arrived.notify_all();
  });
  ASSERT_TRUE(receiver) << receiver.error().text();
  const int out = ::socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  to.sin_port = htons((*receiver)->port());
  const Packet p = message("/ugoki/key/KeyW", {1});
  ASSERT_EQ(::sendto(out, p.data(), p.size(), 0, reinterpret_cast<sockaddr*>(&to), sizeof to), static_cast<ssize_t>(p.size()));
  std::unique_lock lock(mutex);
  EXPECT_TRUE(arrived.wait_for(lock, std::chrono::seconds(20), [&] { return !last.empty(); }));
  const auto change = circuit::read_device_change(last, "input");
  ASSERT_TRUE(change) << change.error().text();
  EXPECT_EQ(change->keys, (std::vector<std::string>{"KeyW"}));
  EXPECT_FALSE(OscReceiver::listen((*receiver)->port(), [](std::string) {})) << "the port is in use";
  ::close(out);
}

}  // namespace
}  // namespace ugoki::player_native
