// OSC packets from the examples of the specification (opensoundcontrol.org, OSC 1.0), damaged packets, and packets over a real socket.
// Also the thread pool.

#include "ugoki/plugin/osc.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <map>

#include "ugoki/plugin/thread_pool.h"

namespace ugoki::plugin {
namespace {

using Bytes = std::vector<std::byte>;

Bytes bytes_of(std::initializer_list<int> values) {
  Bytes out;
  for (const int v : values) out.push_back(static_cast<std::byte>(v));
  return out;
}

// Message of the specification: address "/oscillator/4/frequency", argument 440.0f
const Bytes frequency = bytes_of({0x2f, 0x6f, 0x73, 0x63, 0x69, 0x6c, 0x6c, 0x61, 0x74, 0x6f, 0x72, 0x2f, 0x34, 0x2f, 0x66, 0x72,
                                  0x65, 0x71, 0x75, 0x65, 0x6e, 0x63, 0x79, 0x00, 0x2c, 0x66, 0x00, 0x00, 0x43, 0xdc, 0x00, 0x00});
// Message of the specification: address "/foo", arguments 1000, -1, "hello", 1.234f, 5.678f
const Bytes foo =
    bytes_of({0x2f, 0x66, 0x6f, 0x6f, 0,    0,    0,    0,    0x2c, 0x69, 0x69, 0x73, 0x66, 0x66, 0,    0,    0,    0,    0x03, 0xe8,
              0xff, 0xff, 0xff, 0xff, 0x68, 0x65, 0x6c, 0x6c, 0x6f, 0,    0,    0,    0x3f, 0x9d, 0xf3, 0xb6, 0x40, 0xb5, 0xb2, 0x2d});

/// Messages of a packet by address. @param good [out] result of read_osc
std::map<std::string, std::vector<double>> read(const Bytes& packet, bool& good) {
  std::map<std::string, std::vector<double>> out;
  good = read_osc(packet, [&](std::string_view address, std::span<const double> numbers) {
    out[std::string(address)] = {numbers.begin(), numbers.end()};
  });
  return out;
}

TEST(Osc, ReadsTheExamplesOfTheSpecification) {
  bool good = false;
  auto got = read(frequency, good);
  EXPECT_TRUE(good);
  EXPECT_EQ(got["/oscillator/4/frequency"], std::vector<double>{440});
  got = read(foo, good);
  ASSERT_TRUE(good);
  ASSERT_EQ(got["/foo"].size(), 4u);
  EXPECT_EQ(got["/foo"][1], -1);
  EXPECT_NEAR(got["/foo"][3], 5.678, 1e-6);
  Bytes bundle = bytes_of({'#', 'b', 'u', 'n', 'd', 'l', 'e', 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, static_cast<int>(frequency.size())});
  bundle.insert(bundle.end(), frequency.begin(), frequency.end());
  got = read(bundle, good);
  EXPECT_TRUE(good);
  EXPECT_EQ(got.size(), 1u);
}

TEST(Osc, DamagedPacketsAreRefused) {
  for (std::size_t n = 0; n < foo.size(); ++n) {
    bool good = true;
    EXPECT_TRUE(read(Bytes(foo.begin(), foo.begin() + static_cast<std::ptrdiff_t>(n)), good).empty());
    EXPECT_FALSE(good) << n;
  }
  std::uint32_t x = 12345;
  for (int k = 0; k < 2000; ++k) {
    Bytes packet = k % 2 ? foo : frequency;
    for (int i = 0; i < 4; ++i) {
      x = x * 1664525u + 1013904223u;
      packet[x % packet.size()] = static_cast<std::byte>(x >> 24);
    }
    bool good = false;
    for (const auto& [address, numbers] : read(packet, good))
      for (const double n : numbers) EXPECT_TRUE(n - n == 0);
  }
}

TEST(Osc, ReceivesPacketsFromALocalSocket) {
  Result<OscReceiver> receiver = OscReceiver::open(0);
  ASSERT_TRUE(receiver) << receiver.error().text();
  EXPECT_FALSE(OscReceiver::open(receiver->port()));
  const int socket = ::socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(receiver->port());
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  ASSERT_EQ(::sendto(socket, frequency.data(), frequency.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to),
            static_cast<ssize_t>(frequency.size()));
  ::close(socket);
  double got = 0;
  for (int i = 0; i < 1000 && got == 0; ++i) receiver->poll([&](std::string_view, std::span<const double> n) { got = n[0]; });
  EXPECT_EQ(got, 440);
}

TEST(ThreadPool, EveryWorkerWorksInEveryRound) {
  for (const int n : {1, 2, 5}) {
    ThreadPool pool(n);
    ASSERT_EQ(pool.workers(), n);
    std::vector<long> done(static_cast<std::size_t>(n) * 16);
    for (int round = 0; round < 300; ++round) {
      pool.run([](void* context, int worker) { ++static_cast<long*>(context)[worker * 16]; }, done.data());
      for (int w = 0; w < n; ++w) ASSERT_EQ(done[static_cast<std::size_t>(w) * 16], round + 1);
    }
  }
}

}  // namespace
}  // namespace ugoki::plugin
