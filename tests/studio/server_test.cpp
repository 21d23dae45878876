#include "ugoki/studio/server.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <condition_variable>
#include <fstream>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "client.h"
#include "ugoki/studio/launch_page.h"
#include "ugoki/studio/session_key.h"

namespace ugoki::studio {
namespace {

using test::Reply;
using test::request;
using test::WebSocket;

/// Answers API requests with a description of the request, and messages with their own text.
class Echo final : public ServerEvents {
 public:
  void on_api(ApiRequest r, std::function<void(ApiReply)> answer) override {
    {
      const std::scoped_lock lock(mutex);
      last_body = r.body;
    }
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
  void on_bytes(ClientId client, std::string bytes, std::function<void()> done) override {
    server->send(client, "bytes " + std::to_string(bytes.size()));
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
  std::string last_body;
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
  std::string bearer() const { return "Authorization: Bearer " + server->token(); }
  std::string code() const { return server->address().substr(server->address().find("#code=") + 6); }

  std::filesystem::path web;
  ServerOptions options;
  Echo echo;
  std::unique_ptr<Server> server;
};

TEST_F(ServerTest, ServesThePageWithoutToken) {
  const Reply page = request(port(), "GET", "/");
  EXPECT_EQ(page.status, 200);
  EXPECT_EQ(page.body, "<!doctype html><title>page</title>");
  EXPECT_EQ(page.headers.at("content-type"), "text/html; charset=utf-8");
  EXPECT_FALSE(page.headers.contains("set-cookie"));
  EXPECT_EQ(page.headers.at("cross-origin-opener-policy"), "same-origin");
  EXPECT_EQ(page.headers.at("referrer-policy"), "no-referrer");
  EXPECT_NE(page.headers.at("content-security-policy").find("frame-ancestors 'none'"), std::string::npos);

  const Reply asset = request(port(), "GET", "/assets/a.js");
  EXPECT_EQ(asset.status, 200);
  EXPECT_EQ(asset.body, "let a = 1;");
  EXPECT_EQ(asset.headers.at("content-type"), "text/javascript; charset=utf-8");
  const Reply head = request(port(), "HEAD", "/assets/a.js");
  EXPECT_EQ(head.status, 200);
  EXPECT_EQ(head.headers.at("content-length"), "10");
  EXPECT_EQ(head.body, "");
}

TEST_F(ServerTest, CodeOfTheAddressIsExchangedForTheToken) {
  EXPECT_EQ(server->address(), "http://127.0.0.1:" + std::to_string(port()) + "/#code=" + code());
  EXPECT_EQ(server->address().find(server->token()), std::string::npos);
  const auto exchange = [&](const std::string& body, const std::vector<std::string>& headers = {}) {
    return request(port(), "POST", "/api/session", headers, body);
  };
  const std::string right = nlohmann::json{{"code", code()}}.dump();
  for (int i = 0; i < 2; ++i) {  // the printed address opens further pages
    const Reply reply = exchange(right, {"Origin: http://127.0.0.1:" + std::to_string(port())});
    ASSERT_EQ(reply.status, 200);
    EXPECT_EQ(nlohmann::json::parse(reply.body)["token"], server->token());
    EXPECT_EQ(reply.headers.at("cache-control"), "no-store");
  }
  const Reply wrong = exchange(R"({"code": "wrong"})");
  EXPECT_EQ(wrong.status, 401);
  EXPECT_EQ(wrong.body.find(server->token()), std::string::npos);
  EXPECT_EQ(exchange(R"({"code": ""})").status, 401);
  for (const char* body : {"", "{}", "[]", "3", "{\"code\": 3}", "{code"}) EXPECT_EQ(exchange(body).status, 400) << body;
  EXPECT_EQ(exchange(std::string(2000, 'x')).status, 413);
  EXPECT_EQ(exchange(right, {"Origin: http://127.0.0.1:1"}).status, 403);
  EXPECT_EQ(exchange(right, {"Host: evil.example"}).status, 403);
  EXPECT_EQ(request(port(), "GET", "/api/session").status, 405);
}

TEST_F(ServerTest, TokenIsTheSameAfterRestartOnTheSamePort) {
  server.reset();
  options.key = "a key";
  start();
  options.port = port();
  const std::string token = server->token(), first_code = code();
  server.reset();
  start();
  EXPECT_EQ(server->token(), token);
  EXPECT_NE(code(), first_code);
  EXPECT_EQ(request(port(), "GET", "/api/library", {"Authorization: Bearer " + token}).status, 200);
  server.reset();
  options.key = "another key";
  start();
  EXPECT_NE(server->token(), token);
  EXPECT_NE(derive_token("a key", 4711), derive_token("a key", 4712));
}

TEST_F(ServerTest, RejectsUnauthorisedRequestsWithRemedy) {
  const auto problem = [](const Reply& r) { return nlohmann::json::parse(r.body)["error"]["problems"][0]; };
  Reply r = request(port(), "GET", "/api/library");
  EXPECT_EQ(r.status, 401);
  EXPECT_EQ(problem(r)["message"], "The studio's token is missing.");
  EXPECT_NE(problem(r)["remedy"], "");
  EXPECT_EQ(request(port(), "GET", "/api/library", {"Authorization: Bearer wrong"}).status, 401);
  EXPECT_EQ(request(port(), "GET", "/api/library", {"Authorization: Bearer " + code()}).status, 401);
  EXPECT_EQ(request(port(), "GET", "/api/library?token=" + server->token()).status, 401);
  EXPECT_EQ(request(port(), "GET", "/api/library", {"Cookie: ugoki_" + std::to_string(port()) + "=" + server->token()}).status, 401);
  EXPECT_EQ(request(port(), "GET", "/%61pi/library").status, 401);
  r = request(port(), "GET", "/", {bearer(), "Host: evil.example"});
  EXPECT_EQ(r.status, 403);
  EXPECT_EQ(problem(r)["location"], "Host");
  EXPECT_EQ(request(port(), "GET", "/assets/a.js", {"Host: localhost:" + std::to_string(port())}).status, 403);
  EXPECT_EQ(request(port(), "GET", "/assets/a.js", {"Host: 127.0.0.1:" + std::to_string(port()), "Host: evil.example"}).status / 100, 4);
  r = request(port(), "POST", "/api/import", {bearer(), "Origin: http://evil.example"}, "x");
  EXPECT_EQ(r.status, 403);
  EXPECT_EQ(problem(r)["location"], "Origin");
  EXPECT_EQ(request(port(), "GET", "/", {bearer(), "Origin: null"}).status, 403);
  const std::string own = "Origin: http://127.0.0.1:" + std::to_string(port());
  EXPECT_EQ(request(port(), "GET", "/", {bearer(), own}).status, 200);
  EXPECT_EQ(request(port(), "GET", "/", {bearer(), own, "Origin: http://evil.example"}).status, 403);

  // If a browser opens the address of an API request, it gets the same error sentence as an HTML page.
  r = request(port(), "GET", "/api/library", {"Accept: text/html,*/*"});
  EXPECT_EQ(r.status, 401);
  EXPECT_EQ(r.headers.at("content-type"), "text/html; charset=utf-8");
  EXPECT_NE(r.body.find("The studio's token is missing."), std::string::npos);

  EXPECT_EQ(WebSocket(port(), "/ws").status(), 401);
  EXPECT_EQ(WebSocket(port(), "/ws?token=" + server->token()).status(), 401);
  EXPECT_EQ(WebSocket(port(), "/ws", {"Sec-WebSocket-Protocol: ugoki, ugoki.token.wrong"}).status(), 401);
  EXPECT_EQ(WebSocket(port(), "/ws", {bearer(), "Host: evil.example"}).status(), 403);
  EXPECT_EQ(WebSocket(port(), "/ws", {bearer(), "Origin: http://evil.example"}).status(), 403);
  EXPECT_EQ(WebSocket(port(), "/ws", {bearer(), "Origin: http://127.0.0.1:" + std::to_string(port())}).status(), 101);
  EXPECT_EQ(WebSocket(port(), "/ws", {"Sec-WebSocket-Protocol: ugoki, ugoki.token." + server->token()}).status(), 101);
}

TEST(SessionKey, HmacHasThePublishedValues) {  // RFC 4231, test cases 1, 2 and 6
  EXPECT_EQ(hmac_sha256(std::string(20, '\x0b'), "Hi There"), "b0344c61d8db38535ca8afceaf0bf12b881dc200c9833da726e9376c2e32cff7");
  EXPECT_EQ(hmac_sha256("Jefe", "what do ya want for nothing?"), "5bdcc146bf60754e6a042426089575c75a003f089d2739839dec58b964ec3843");
  EXPECT_EQ(hmac_sha256(std::string(131, '\xaa'), "Test Using Larger Than Block-Size Key - Hash Key First"),
            "60e431591ee0b67f0d8a26aacbf5b77f8e0bc6213728c5140546040f0ee37f54");
}

TEST(SessionKey, IsKeptInAPrivateFile) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::temp_directory_path() / ("ugoki_key_test_" + std::to_string(getpid()));
  const std::string path = (folder / "a" / "studio.key").string();
  const Result<std::string> key = read_or_make_key(path);
  ASSERT_TRUE(key) << key.error().text();
  EXPECT_EQ(key->size(), 43u);
  EXPECT_EQ(fs::status(path).permissions(), fs::perms::owner_read | fs::perms::owner_write);
  EXPECT_EQ(read_or_make_key(path).value_or(""), *key);
  fs::permissions(path, fs::perms::others_read, fs::perm_options::add);
  const std::string replaced = read_or_make_key(path).value_or("");
  EXPECT_EQ(replaced.size(), 43u);
  EXPECT_NE(replaced, *key) << "others could read the old key";
  EXPECT_EQ(fs::status(path).permissions(), fs::perms::owner_read | fs::perms::owner_write);
  std::ofstream(path) << "short";
  EXPECT_EQ(read_or_make_key(path).value_or("").size(), 43u);
  EXPECT_FALSE(read_or_make_key("/proc/none/studio.key"));
  fs::remove_all(folder);
}

TEST(LaunchPage, IsPrivateAndRemoved) {
  std::string path;
  {
    const Result<std::unique_ptr<LaunchPage>> page = LaunchPage::write("http://127.0.0.1:1/#code=c");
    ASSERT_TRUE(page) << page.error().text();
    path = (*page)->path();
    EXPECT_EQ(std::filesystem::status(path).permissions(), std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
    EXPECT_TRUE(path.ends_with(".html"));
    std::ifstream in(path);
    const std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    EXPECT_NE(text.find("content=\"0;url=http://127.0.0.1:1/#code=c\""), std::string::npos);
  }
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST_F(ServerTest, FilesOutsideTheWebFolderAreNotServed) {
  for (const char* path : {"/../secret.txt", "/%2e%2e/secret.txt", "/assets/../../secret.txt", "/assets/%2e%2e%2f%2e%2e/secret.txt",
                           "/link.txt", "/..%5csecret.txt", "//etc/passwd", "/assets", "/nothing.js", "/assets/a.js/x"}) {
    const Reply r = request(port(), "GET", path, {bearer()});
    EXPECT_EQ(r.status, 404) << path;
    EXPECT_EQ(r.body.find("secret content"), std::string::npos) << path;
  }
  EXPECT_EQ(request(port(), "GET", "/a%00b", {bearer()}).status, 400);
  EXPECT_EQ(request(port(), "GET", "http://evil.example/", {bearer()}).status, 400);
}

TEST_F(ServerTest, ForwardsApiRequests) {
  const Reply get = request(port(), "GET", "/api/library?kind=motion", {bearer()});
  EXPECT_EQ(get.status, 200);
  EXPECT_EQ(nlohmann::json::parse(get.body)["got"], "GET /api/library kind=motion 0");
  const Reply post = request(port(), "POST", "/api/import?name=a", {bearer()}, std::string(3'000'000, 'x'));
  EXPECT_EQ(post.status, 200);
  EXPECT_NE(post.body.find(" 3000000"), std::string::npos);
  const Reply chunked = request(port(), "POST", "/api/import", {bearer(), "Transfer-Encoding: chunked", "Content-Length: 0"}, "");
  EXPECT_EQ(chunked.status, 400);  // Transfer-Encoding and Content-Length together are ambiguous
}

TEST_F(ServerTest, ReadsLargeBodiesUnchangedOnOneConnection) {
  test::Socket socket(port());
  for (const std::size_t size : {std::size_t{512} * 1024 - 1, std::size_t{512} * 1024, std::size_t{3'110'400}, std::size_t{7}}) {
    std::string body(size, '\0');
    for (std::size_t i = 0; i < size; ++i) body[i] = static_cast<char>((i * 2654435761u) >> 13);
    socket.send("POST /api/import HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(port()) + "\r\n" + bearer() +
                "\r\nContent-Length: " + std::to_string(size) + "\r\n\r\n" + body.substr(0, size / 3));
    socket.send(body.substr(size / 3));
    std::string got;
    const std::string wanted = "POST /api/import  " + std::to_string(size);
    while (got.find(wanted) == std::string::npos) {
      const std::string part = socket.receive(4096);
      ASSERT_FALSE(part.empty()) << size;
      got += part;
    }
    const std::scoped_lock lock(echo.mutex);
    EXPECT_TRUE(echo.last_body == body) << size;
  }
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
  EXPECT_EQ(request(port(), "POST", "/api/import", {bearer()}, std::string(2 << 20, 'x')).status, 413);
  EXPECT_EQ(request(port(), "POST", "/api/import", {bearer(), "Content-Length: 99999999999999"}, "x").status, 413);
  EXPECT_EQ(request(port(), "POST", "/api/other", {bearer()}, std::string(300'000, 'x')).status, 413);
  std::string chunks;
  for (int i = 0; i < 40; ++i) chunks += "10000\r\n" + std::string(0x10000, 'x') + "\r\n";
  test::Socket socket(port());
  socket.send("POST /api/import HTTP/1.1\r\n" + bearer() + "\r\nHost: 127.0.0.1:" + std::to_string(port()) +
              "\r\nTransfer-Encoding: chunked\r\n\r\n");
  socket.send(chunks);
  EXPECT_TRUE(socket.receive_all().starts_with("HTTP/1.1 413"));
  const Reply header = request(port(), "GET", "/", {"X-Long: " + std::string(100'000, 'x')});
  EXPECT_TRUE(header.status == 431 || header.status == 0) << header.status;

  WebSocket big(port(), "/ws", {bearer()});
  big.send_text(std::string(100'000, 'x'));
  const auto answer = big.receive();
  EXPECT_TRUE(!answer || answer->opcode == 8);
  EXPECT_EQ(request(port(), "GET", "/assets/a.js").status, 200);
}

TEST_F(ServerTest, SurvivesInvalidHttp) {
  const std::string host = "Host: 127.0.0.1:" + std::to_string(port()) + "\r\n";
  const std::string garbage[] = {"\r\n\r\n",
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
                                 "POST /api/import HTTP/1.1\r\n" + bearer() + "\r\n" + host + "Transfer-Encoding: chunked\r\n\r\nzzz\r\n"};
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
  WebSocket socket(port(), "/ws", {bearer()});
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
  WebSocket good(port(), "/ws", {bearer()});
  {
    WebSocket unmasked(port(), "/ws", {bearer()});
    unmasked.send_frame(1, "hello", false);
    const auto answer = unmasked.receive();
    EXPECT_TRUE(!answer || answer->opcode == 8);
  }
  {
    WebSocket reserved(port(), "/ws", {bearer()});
    reserved.send_frame(0xb, "hello");
    const auto answer = reserved.receive();
    EXPECT_TRUE(!answer || answer->opcode == 8);
  }
  {
    WebSocket not_utf8(port(), "/ws", {bearer()});
    not_utf8.send_text("\xff\xfe\xfd");
    const auto answer = not_utf8.receive();
    EXPECT_TRUE(!answer || answer->opcode == 8);
  }
  {
    WebSocket binary(port(), "/ws", {bearer()});
    binary.send_frame(2, "bytes");
    const auto answer = binary.receive();
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->opcode, 8);
  }
  {
    WebSocket gone(port(), "/ws", {bearer()});
  }
  EXPECT_TRUE(echo.wait_closed(5));
  good.send_text("still here");
  const auto answer = good.receive();
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->data, "echo still here");
}

TEST_F(ServerTest, BinaryMessagesArriveInOrderWithTextsIfTheyAreAllowed) {
  server.reset();
  options.binary_messages = true;
  start();
  WebSocket page(port(), "/ws", {bearer()});
  page.send_text("1");
  page.send_frame(2, std::string("\0\xff", 2));
  page.send_text("2");
  for (const char* expected : {"echo 1", "bytes 2", "echo 2"}) {
    const auto answer = page.receive();
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->data, expected);
  }
}

TEST_F(ServerTest, BroadcastsToAllPages) {
  WebSocket a(port(), "/ws", {bearer()}), b(port(), "/ws", {bearer()});
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
  WebSocket slow(port(), "/ws", {bearer()}), quick(port(), "/ws", {bearer()});
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
  WebSocket stuck(port(), "/ws", {bearer()});
  stuck.send_text("x");
  ASSERT_TRUE(stuck.receive());
  for (int i = 0; i < 40; ++i) server->broadcast(std::string(1 << 20, 'x'));
  EXPECT_TRUE(echo.wait_closed(1));
  EXPECT_EQ(request(port(), "GET", "/assets/a.js").status, 200);
}

TEST_F(ServerTest, ReadsNextMessageOnlyAfterDone) {
  echo.hold = true;
  WebSocket socket(port(), "/ws", {bearer()});
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
    WebSocket a(port(), "/ws", {bearer()}), b(port(), "/ws", {bearer()});
    EXPECT_EQ(a.status(), 101);
    EXPECT_EQ(b.status(), 101);
    EXPECT_EQ(request(port(), "GET", "/assets/a.js").status, 0);
  }
  ASSERT_TRUE(echo.wait_closed(2));
  EXPECT_EQ(request(port(), "GET", "/assets/a.js").status, 200);
}

TEST_F(ServerTest, IdleConnectionsDoNotLockThePageOut) {
  server.reset();
  options.max_connections = 8;
  options.header_time = options.request_time = std::chrono::seconds(600);
  start();
  const std::string host = "Host: 127.0.0.1:" + std::to_string(port()) + "\r\n";
  WebSocket page(port(), "/ws", {bearer()});
  ASSERT_EQ(page.status(), 101);
  std::vector<std::unique_ptr<test::Socket>> idle;
  for (int i = 0; i < 20; ++i) {
    idle.push_back(std::make_unique<test::Socket>(port()));
    if (i % 3 == 1) idle.back()->send("GET / HT");
    if (i % 3 == 2) idle.back()->send("POST /api/session HTTP/1.1\r\n" + host + "Content-Length: 100\r\n\r\n");
  }
  EXPECT_EQ(request(port(), "GET", "/assets/a.js").status, 200);
  EXPECT_EQ(idle.front()->receive_all(), "") << "the oldest one was closed";
  page.send_text("x");
  EXPECT_TRUE(page.receive()) << "a page that is open stays connected";
}

TEST_F(ServerTest, SlowUploadsDoNotLockOtherClientsOut) {
  server.reset();
  options.upload_time = std::chrono::seconds(1);
  start();
  const std::string head = "POST /api/import HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(port()) + "\r\n" + bearer() + "\r\n";
  std::vector<std::unique_ptr<test::Socket>> slow;
  for (int i = 0; i < 140; ++i) {  // more than max_connections
    slow.push_back(std::make_unique<test::Socket>(port()));
    slow.back()->send(head + "Content-Length: 100000\r\n\r\nx");
  }
  const std::string body(10'000, 'y');
  EXPECT_EQ(request(port(), "GET", "/api/library", {bearer()}).status, 200);
  EXPECT_EQ(request(port(), "GET", "/").status, 200);
  EXPECT_TRUE(slow.back()->receive_all().starts_with("HTTP/1.1 503 ")) << "further uploads are refused with an answer";
  std::this_thread::sleep_for(options.upload_time);
  test::Socket upload(port());  // replaces the oldest slow upload
  upload.send(head + "Connection: close\r\nContent-Length: 10000\r\n\r\n");
  EXPECT_EQ(slow.front()->receive_all(), "") << "the oldest upload was closed";
  upload.send(body);
  EXPECT_TRUE(upload.receive_all().starts_with("HTTP/1.1 200 "));
}

TEST_F(ServerTest, RefusedRequestIsNotReadForEver) {
  test::Socket socket(port());
  socket.send("POST /api/import HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(port()) + "\r\nContent-Length: 100000\r\n\r\n");
  EXPECT_TRUE(socket.receive(13).starts_with("HTTP/1.1 401 "));
  bool open = true;
  for (int i = 0; i < 100 && open; ++i) {  // a client that sends one byte every 100 ms; the studio reads for 2 s
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    open = socket.send("x");
  }
  EXPECT_FALSE(open);
}

TEST_F(ServerTest, ChildProcessesInheritNoSocket) {
  WebSocket page(port(), "/ws", {bearer()});
  ASSERT_EQ(page.status(), 101);
  int sockets = 0;
  for (const auto& file : std::filesystem::directory_iterator("/proc/self/fd")) {
    const int fd = std::stoi(file.path().filename().string());
    sockaddr_in address{};
    socklen_t size = sizeof address;
    if (::getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size) != 0 || ntohs(address.sin_port) != port()) continue;
    ++sockets;
    EXPECT_NE(::fcntl(fd, F_GETFD) & FD_CLOEXEC, 0) << "descriptor " << fd;
  }
  EXPECT_EQ(sockets, 2) << "the listening socket and the page's connection";
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
  options.header_time = std::chrono::seconds(1);
  start();
  test::Socket socket(port());
  socket.send("GET / HTTP/1.1\r\n");
  EXPECT_EQ(socket.receive_all(20), "");
}

}  // namespace
}  // namespace ugoki::studio
