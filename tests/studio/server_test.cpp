#include "ugoki/studio/server.h"

#include <gtest/gtest.h>
#include <sys/socket.h>

#include <condition_variable>
#include <fstream>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "client.h"

namespace ugoki::studio {
namespace {

using test::Reply;
using test::request;
using test::WebSocket;

/// Answers API requests with a description of the request, and messages with their own text.
class Echo final : public ServerEvents {
 public:
  void on_api(ApiRequest r, std::function<void(ApiReply)> answer) override {
    std::thread([answer = std::move(answer), text = r.method + " " + r.path + " " + r.query + " " + std::to_string(r.body.size())] {
      answer({200, nlohmann::json{{"got", text}}.dump()});
    }).detach();
  }
  void on_message(ClientId client, std::string text, std::function<void()> done) override {
    {
      const std::scoped_lock lock(mutex);
      if (hold) {
        held.push_back(std::move(done));
        return;
      }
    }
    server->send(client, "echo " + text);
    done();
  }
  void on_close(ClientId) override {
    const std::scoped_lock lock(mutex);
    ++closed;
    changed.notify_all();
  }
  bool wait_closed(int count) {
    std::unique_lock lock(mutex);
    return changed.wait_for(lock, std::chrono::seconds(20), [&] { return closed >= count; });
  }

  Server* server = nullptr;
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<std::function<void()>> held;
  bool hold = false;
  int closed = 0;
};

class ServerTest : public testing::Test {
 protected:
  void SetUp() override {
    web = std::filesystem::temp_directory_path() / ("ugoki_server_test_" + std::to_string(getpid()));
    std::filesystem::create_directories(web / "page" / "assets");
    std::ofstream(web / "secret.txt") << "secret content";
    std::ofstream(web / "page" / "index.html") << "<!doctype html><title>page</title>";
    std::ofstream(web / "page" / "assets" / "a.js") << "let a = 1;";
    std::filesystem::create_symlink(web / "secret.txt", web / "page" / "link.txt");
    start();
  }
  void TearDown() override {
    server.reset();
    std::filesystem::remove_all(web);
  }
  void start() {
    options.web = web / "page";
    Result<std::unique_ptr<Server>> made = Server::listen(options, echo);
    ASSERT_TRUE(made) << made.error().text();
    server = std::move(*made);
    echo.server = server.get();
  }
  std::uint16_t port() const { return server->port(); }
  std::string query() const { return "?token=" + server->token(); }
  std::string cookie() const { return "Cookie: ugoki_" + std::to_string(port()) + "=" + server->token(); }
  std::string ws() const { return "/ws" + query(); }

  std::filesystem::path web;
  ServerOptions options;
  Echo echo;
  std::unique_ptr<Server> server;
};

TEST_F(ServerTest, ServesThePageAndSetsTheCookie) {
  const Reply page = request(port(), "GET", "/" + query());
  EXPECT_EQ(page.status, 200);
  EXPECT_EQ(page.body, "<!doctype html><title>page</title>");
  EXPECT_EQ(page.headers.at("content-type"), "text/html; charset=utf-8");
  const std::string set = page.headers.at("set-cookie");
  EXPECT_EQ(set, "ugoki_" + std::to_string(port()) + "=" + server->token() + "; Path=/; HttpOnly; SameSite=Strict");
  EXPECT_NE(page.headers.at("content-security-policy").find("frame-ancestors 'none'"), std::string::npos);
  EXPECT_EQ(request(port(), "GET", "/", {cookie()}).status, 200);
  EXPECT_FALSE(request(port(), "GET", "/", {cookie()}).headers.contains("set-cookie"));

  const Reply asset = request(port(), "GET", "/assets/a.js");
  EXPECT_EQ(asset.status, 200);
  EXPECT_EQ(asset.body, "let a = 1;");
  EXPECT_EQ(asset.headers.at("content-type"), "text/javascript; charset=utf-8");
  const Reply head = request(port(), "HEAD", "/assets/a.js");
  EXPECT_EQ(head.status, 200);
  EXPECT_EQ(head.headers.at("content-length"), "10");
  EXPECT_EQ(head.body, "");
}

TEST_F(ServerTest, RejectsUnauthorisedRequestsWithRemedy) {
  const auto problem = [](const Reply& r) { return nlohmann::json::parse(r.body)["error"]["problems"][0]; };
  Reply r = request(port(), "GET", "/");
  EXPECT_EQ(r.status, 401);
  EXPECT_EQ(problem(r)["message"], "The studio's token is missing.");
  EXPECT_NE(problem(r)["remedy"], "");
  EXPECT_EQ(request(port(), "GET", "/?token=wrong").status, 401);
  EXPECT_EQ(request(port(), "GET", "/api/library").status, 401);
  EXPECT_EQ(request(port(), "GET", "/api/library?token=").status, 401);
  EXPECT_EQ(request(port(), "GET", "/%61pi/library").status, 401);
  r = request(port(), "GET", "/" + query(), {"Host: evil.example"});
  EXPECT_EQ(r.status, 403);
  EXPECT_EQ(problem(r)["location"], "Host");
  EXPECT_EQ(request(port(), "GET", "/assets/a.js", {"Host: localhost:" + std::to_string(port())}).status, 403);
  EXPECT_EQ(request(port(), "GET", "/assets/a.js", {"Host: 127.0.0.1:" + std::to_string(port()), "Host: evil.example"}).status / 100, 4);
  r = request(port(), "POST", "/api/import" + query(), {"Origin: http://evil.example"}, "x");
  EXPECT_EQ(r.status, 403);
  EXPECT_EQ(problem(r)["location"], "Origin");
  EXPECT_EQ(request(port(), "GET", "/", {cookie(), "Origin: null"}).status, 403);

  // A browser that opens the address without the token shows the same sentence in a page.
  r = request(port(), "GET", "/", {"Accept: text/html,*/*"});
  EXPECT_EQ(r.status, 401);
  EXPECT_EQ(r.headers.at("content-type"), "text/html; charset=utf-8");
  EXPECT_NE(r.body.find("The studio's token is missing."), std::string::npos);

  EXPECT_EQ(WebSocket(port(), "/ws").status(), 401);
  EXPECT_EQ(WebSocket(port(), "/ws?token=wrong").status(), 401);
  EXPECT_EQ(WebSocket(port(), ws(), {"Host: evil.example"}).status(), 403);
  EXPECT_EQ(WebSocket(port(), ws(), {"Origin: http://evil.example"}).status(), 403);
  EXPECT_EQ(WebSocket(port(), ws(), {"Origin: http://127.0.0.1:" + std::to_string(port())}).status(), 101);
  EXPECT_EQ(WebSocket(port(), "/ws", {cookie()}).status(), 101);
}

TEST_F(ServerTest, FilesOutsideTheWebFolderAreNotServed) {
  for (const char* path : {"/../secret.txt", "/%2e%2e/secret.txt", "/assets/../../secret.txt", "/assets/%2e%2e%2f%2e%2e/secret.txt",
                           "/link.txt", "/..%5csecret.txt", "//etc/passwd", "/assets", "/nothing.js", "/assets/a.js/x"}) {
    const Reply r = request(port(), "GET", path, {cookie()});
    EXPECT_EQ(r.status, 404) << path;
    EXPECT_EQ(r.body.find("secret content"), std::string::npos) << path;
  }
  EXPECT_EQ(request(port(), "GET", "/a%00b", {cookie()}).status, 400);
  EXPECT_EQ(request(port(), "GET", "http://evil.example/", {cookie()}).status, 400);
}

TEST_F(ServerTest, ForwardsApiRequests) {
  const Reply get = request(port(), "GET", "/api/library?kind=motion&token=" + server->token());
  EXPECT_EQ(get.status, 200);
  EXPECT_EQ(nlohmann::json::parse(get.body)["got"], "GET /api/library kind=motion&token=" + server->token() + " 0");
  const Reply post = request(port(), "POST", "/api/import?name=a", {cookie()}, std::string(3'000'000, 'x'));
  EXPECT_EQ(post.status, 200);
  EXPECT_NE(post.body.find(" 3000000"), std::string::npos);
  const Reply chunked = request(port(), "POST", "/api/import", {cookie(), "Transfer-Encoding: chunked", "Content-Length: 0"}, "");
  EXPECT_EQ(chunked.status, 400);  // Transfer-Encoding and Content-Length together are ambiguous
}

TEST_F(ServerTest, KeepsConnectionForSeveralRequests) {
  test::Socket socket(port());
  for (int i = 0; i < 3; ++i) {
    socket.send("GET /assets/a.js HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(port()) + "\r\n\r\n");
    std::string got;
    while (got.find("let a = 1;") == std::string::npos) {
      const std::string part = socket.receive(4096);
      ASSERT_FALSE(part.empty());
      got += part;
    }
  }
}

TEST_F(ServerTest, RejectsTooLargeRequests) {
  server.reset();
  options.max_import_bytes = 1 << 20;
  options.max_message_bytes = 1 << 16;
  start();
  EXPECT_EQ(request(port(), "POST", "/api/import" + query(), {}, std::string(2 << 20, 'x')).status, 413);
  EXPECT_EQ(request(port(), "POST", "/api/import" + query(), {"Content-Length: 99999999999999"}, "x").status, 413);
  EXPECT_EQ(request(port(), "POST", "/api/other" + query(), {}, std::string(300'000, 'x')).status, 413);
  std::string chunks;
  for (int i = 0; i < 40; ++i) chunks += "10000\r\n" + std::string(0x10000, 'x') + "\r\n";
  test::Socket socket(port());
  socket.send("POST /api/import" + query() + " HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(port()) +
              "\r\nTransfer-Encoding: chunked\r\n\r\n");
  socket.send(chunks);
  EXPECT_TRUE(socket.receive_all().starts_with("HTTP/1.1 413"));
  const Reply header = request(port(), "GET", "/", {"X-Long: " + std::string(100'000, 'x')});
  EXPECT_TRUE(header.status == 431 || header.status == 0) << header.status;

  WebSocket big(port(), ws());
  big.send_text(std::string(100'000, 'x'));
  const auto answer = big.receive();
  EXPECT_TRUE(!answer || answer->opcode == 8);
  EXPECT_EQ(request(port(), "GET", "/assets/a.js").status, 200);
}

TEST_F(ServerTest, SurvivesInvalidHttp) {
  const std::string host = "Host: 127.0.0.1:" + std::to_string(port()) + "\r\n";
  const std::string garbage[] = {
      "\r\n\r\n",
      "GET\r\n\r\n",
      "GET / HTTP/9.9\r\n\r\n",
      std::string(5000, '\0'),
      std::string(5000, '\xff'),
      "\x16\x03\x01\x02\x00\x01",
      "POST /api/import HTTP/1.1\r\n" + host + "Content-Length: -5\r\n\r\n",
      "POST /api/import HTTP/1.1\r\n" + host + "Content-Length: x\r\n\r\n",
      "GET / HTTP/1.1\r\nHost\r\n\r\n",
      "BREW / HTTP/1.1\r\n" + host + "\r\n",
      "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n",
      "POST " + ("/api/import" + query()) + " HTTP/1.1\r\n" + host + "Transfer-Encoding: chunked\r\n\r\nzzz\r\n"};
  for (const std::string& text : garbage) {
    test::Socket socket(port());
    socket.send(text);
    ::shutdown(socket.fd(), SHUT_WR);
    const std::string answer = socket.receive_all();
    if (!answer.empty()) EXPECT_TRUE(answer.starts_with("HTTP/1.1 4") || answer.starts_with("HTTP/1.0 4")) << answer.substr(0, 80);
  }
  {
    test::Socket half(port());
    half.send("GET / HT");
  }
  EXPECT_EQ(request(port(), "GET", "/assets/a.js").status, 200);
}

TEST_F(ServerTest, WebSocketEchoes) {
  WebSocket socket(port(), ws());
  ASSERT_EQ(socket.status(), 101);
  for (const std::size_t size :
       {std::size_t{1}, std::size_t{125}, std::size_t{126}, std::size_t{65535}, std::size_t{65536}, std::size_t{500'000}}) {
    const std::string text(size, 'x');
    socket.send_text(text);
    const auto answer = socket.receive();
    ASSERT_TRUE(answer) << size;
    EXPECT_EQ(answer->opcode, 1);
    EXPECT_EQ(answer->data, "echo " + text);
  }
}

TEST_F(ServerTest, MalformedWebSocketFramesCloseOnlyThatConnection) {
  WebSocket good(port(), ws());
  {
    WebSocket unmasked(port(), ws());
    unmasked.send_frame(1, "hello", false);
    const auto answer = unmasked.receive();
    EXPECT_TRUE(!answer || answer->opcode == 8);
  }
  {
    WebSocket reserved(port(), ws());
    reserved.send_frame(0xb, "hello");
    const auto answer = reserved.receive();
    EXPECT_TRUE(!answer || answer->opcode == 8);
  }
  {
    WebSocket not_utf8(port(), ws());
    not_utf8.send_text("\xff\xfe\xfd");
    const auto answer = not_utf8.receive();
    EXPECT_TRUE(!answer || answer->opcode == 8);
  }
  {
    WebSocket binary(port(), ws());
    binary.send_frame(2, "bytes");
    const auto answer = binary.receive();
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->opcode, 8);
  }
  {
    WebSocket gone(port(), ws());
  }
  EXPECT_TRUE(echo.wait_closed(5));
  good.send_text("still here");
  const auto answer = good.receive();
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->data, "echo still here");
}

TEST_F(ServerTest, BroadcastsToAllPages) {
  WebSocket a(port(), ws()), b(port(), ws());
  for (WebSocket* s : {&a, &b}) {  // a reply shows that the connection is open
    s->send_text("x");
    ASSERT_TRUE(s->receive());
  }
  server->broadcast("{\"event\":\"log\"}");
  server->broadcast_frame(std::make_shared<std::vector<std::byte>>(100, std::byte{7}));
  for (WebSocket* s : {&a, &b}) {
    EXPECT_EQ(s->receive()->data, "{\"event\":\"log\"}");
    const auto frame = s->receive();
    EXPECT_EQ(frame->opcode, 2);
    EXPECT_EQ(frame->data, std::string(100, '\7'));
  }
}

TEST_F(ServerTest, SlowPageSkipsFramesAndDelaysNoOtherPage) {
  WebSocket slow(port(), ws()), quick(port(), ws());
  for (WebSocket* s : {&slow, &quick}) {
    s->send_text("x");
    ASSERT_TRUE(s->receive());
  }
  constexpr int count = 400;
  constexpr std::size_t size = 200'000;  // bytes; all frames together are 80 MB, far more than the sockets' buffers
  for (int i = 0; i < count; ++i) {
    auto frame = std::make_shared<std::vector<std::byte>>(size);
    (*frame)[0] = static_cast<std::byte>(i & 255);
    (*frame)[1] = static_cast<std::byte>(i >> 8);
    server->broadcast_frame(frame);
    const auto got = quick.receive();  // the fast page gets every frame although the slow page reads none
    ASSERT_TRUE(got);
    ASSERT_EQ(static_cast<unsigned char>(got->data[0]) + 256 * static_cast<unsigned char>(got->data[1]), i);
  }
  int received = 0, last = -1;
  while (last != count - 1) {
    const auto got = slow.receive();
    ASSERT_TRUE(got);
    const int number = static_cast<unsigned char>(got->data[0]) + 256 * static_cast<unsigned char>(got->data[1]);
    ASSERT_GT(number, last);
    last = number;
    ++received;
  }
  EXPECT_LT(received, count / 2);
}

TEST_F(ServerTest, PageThatDoesNotReadIsDisconnected) {
  server.reset();
  options.max_waiting_bytes = 4 << 20;
  start();
  WebSocket stuck(port(), ws());
  stuck.send_text("x");
  ASSERT_TRUE(stuck.receive());
  for (int i = 0; i < 40; ++i) server->broadcast(std::string(1 << 20, 'x'));
  EXPECT_TRUE(echo.wait_closed(1));
  EXPECT_EQ(request(port(), "GET", "/assets/a.js").status, 200);
}

TEST_F(ServerTest, ReadsNextMessageOnlyAfterDone) {
  echo.hold = true;
  WebSocket socket(port(), ws());
  for (int i = 0; i < 10; ++i) socket.send_text("x");
  const auto held = [&] {
    const std::scoped_lock lock(echo.mutex);
    return echo.held.size();
  };
  while (held() == 0) std::this_thread::yield();
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_EQ(held(), 1u);
  echo.held.front()();
  while (held() == 1) std::this_thread::yield();
  EXPECT_EQ(held(), 2u);
}

TEST_F(ServerTest, TooManyConnectionsAreClosed) {
  server.reset();
  options.max_connections = 2;
  start();
  {
    WebSocket a(port(), ws()), b(port(), ws());
    EXPECT_EQ(a.status(), 101);
    EXPECT_EQ(b.status(), 101);
    EXPECT_EQ(request(port(), "GET", "/assets/a.js").status, 0);
  }
  ASSERT_TRUE(echo.wait_closed(2));
  EXPECT_EQ(request(port(), "GET", "/assets/a.js").status, 200);
}

TEST_F(ServerTest, PortInUseIsReported) {
  ServerOptions same;
  same.port = port();
  Echo other;
  const Result<std::unique_ptr<Server>> made = Server::listen(same, other);
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().problems[0].location, "127.0.0.1:" + std::to_string(port()));
  EXPECT_NE(made.error().problems[0].remedy, "");
}

TEST_F(ServerTest, SlowHeadersTimeOut) {
  server.reset();
  options.request_time = std::chrono::seconds(1);
  start();
  test::Socket socket(port());
  socket.send("GET / HTTP/1.1\r\n");
  EXPECT_EQ(socket.receive_all(20), "");
}

}  // namespace
}  // namespace ugoki::studio
