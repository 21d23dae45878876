#include "page_session.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "ugoki/base/number.h"
#include "ugoki/content/inputs.h"
#include "ugoki/content/mechanism_display.h"
#include "ugoki/json/fields.h"

namespace ugoki::player_native {
namespace {

using json::Json;
using Clock = std::chrono::steady_clock;

constexpr double max_advance = 1;         // maximum time that one message may advance the content, s
constexpr double max_steps = 10'000'000;  // maximum number of steps that one message may request

std::string hex(std::uint64_t x) {
  std::string out(16, '0');
  for (std::size_t i = 0; i < 16; ++i) out[i] = "0123456789abcdef"[(x >> (60 - 4 * i)) & 15];
  return out;
}

Vec3 vector(json::Fields& f, const char* key) {
  double x[3] = {0, 0, 0};
  f.require(key, "three numbers");
  f.numbers(key, x);
  return {x[0], x[1], x[2]};
}

}  // namespace

PageSession::PageSession(content::Player player) : player_(std::move(player)) { player_.hold(held_); }
PageSession::~PageSession() { stop(); }

void PageSession::start(studio::Outbox& outbox) {
  outbox_ = &outbox;
  thread_ = std::thread([this] { run(); });
}

void PageSession::stop() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  arrived_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void PageSession::on_api(studio::ApiRequest, std::function<void(studio::ApiReply)> answer) {
  answer({404, R"({"error": "This program answers its page only."})"});
}

void PageSession::on_message(studio::ClientId client, std::string text, std::function<void()> done) {
  {
    const std::lock_guard lock(mutex_);
    messages_.push_back({client, std::move(text), std::move(done)});
  }
  arrived_.notify_one();
}

void PageSession::on_close(studio::ClientId client) {
  on_message(client, R"({"op": "left"})", [] {});
}

void PageSession::run() {
  for (;;) {
    Message message;
    {
      std::unique_lock lock(mutex_);
      arrived_.wait(lock, [&] { return ending_ || !messages_.empty(); });
      if (ending_) return;
      message = std::move(messages_.front());
      messages_.pop_front();
    }
    handle(message);
    message.done();
  }
}

/// Sends the values of the variables if they have changed.
void PageSession::send_variables() {
  player_.variable_values(variables_);
  if (variables_ == sent_variables_) return;
  sent_variables_ = variables_;
  outbox_->broadcast(json::to_text(Json{{"event", "variables"}, {"values", variables_}}));
}

void PageSession::send_frame() {
  send_variables();
  player_.display_frame(frame_);
  auto bytes = std::make_shared<std::vector<std::byte>>();
  const auto number = static_cast<std::uint32_t>(std::llround(player_.time() * player_.content().frame_rate));
  content::encode_frame(frame_, number, content::frame_simulate | content::frame_live, *bytes);
  outbox_->broadcast_frame(std::move(bytes));
}

void PageSession::send_stopped(const Error& error) {
  outbox_->broadcast(json::to_text(Json{{"event", "stopped"}, {"reason", error.text()}}));
}

void PageSession::handle(const Message& message) {
  const Result<Json> json = json::parse_json(message.text, "message");
  Error problems;
  Json result;
  bool wants_answer = false;
  Json id;
  if (!json) {
    problems = json.error();
  } else {
    json::Fields f(*json, "message:", problems);
    std::string op;
    f.text("op", op);
    if (const Json* given = f.find("id")) {
      id = *given;
      wants_answer = true;
    }
    int character = 0, link = 0;
    double duration = 0.2, seconds = 0, budget = 0.013, count = 0;
    f.integer("character", character);
    f.integer("link", link);
    f.number("duration", duration);
    if (op == "hello") {
      sent_variables_.clear();  // the new page has no values
      const Result<Json> scene = json::parse_json(content::scene_json(player_.content()), "scene", std::size_t{1} << 31);
      const Result<Json> devices = json::parse_json(circuit::write_device_use(player_.devices().use()), "devices");
      outbox_->send(message.client,
                    json::to_text(Json{{"event", "scene"}, {"scene", scene ? *scene : Json()}, {"devices", devices ? *devices : Json()}}));
      send_frame();
    } else if (op == "advance") {
      f.number("seconds", seconds);
      f.number("budget", budget);
      const auto steps = static_cast<long>(std::floor(std::clamp(seconds, 0.0, max_advance) / player_.step_size() + 1e-6));
      const auto deadline = Clock::now() + std::chrono::duration<double>(std::clamp(budget, 0.001, 1.0));
      for (long i = 0; i < steps && Clock::now() < deadline; ++i)
        if (const Result<void> good = player_.step(); !good) {
          send_stopped(good.error());
          break;
        }
      send_frame();
    } else if (op == "step") {
      f.number("count", count);
      long done = 0;
      for (const long wanted = static_cast<long>(std::clamp(count, 0.0, max_steps)); done < wanted; ++done)
        if (const Result<void> good = player_.step(); !good) {
          send_stopped(good.error());
          break;
        }
      result = done;
      send_frame();
    } else if (op == "reset") {
      player_.reset();
      held_.mouse.wheel = 0;
      player_.hold(held_);
      send_frame();
    } else if (op == "push") {
      const Vec3 force = vector(f, "force");
      if (problems.empty()) player_.push(character, link, force, duration);
    } else if (op == "grab") {
      const Vec3 point = vector(f, "point"), target = vector(f, "target");
      if (problems.empty()) player_.grab(character, link, point, target);
    } else if (op == "drag") {
      const Vec3 target = vector(f, "target");
      if (problems.empty()) player_.drag(target);
    } else if (op == "release") {
      player_.release();
    } else if (op == "left") {  // the page was closed: release all keys and the grabbed character
      player_.release();
      held_ = {};
      player_.hold(held_);
    } else if (op == "input") {
      if (const auto change = circuit::read_device_change(message.text, "input"); change) {
        circuit::apply(*change, held_);
        player_.hold(held_);
      } else {
        problems = change.error();
      }
    } else if (op == "schedule") {
      if (auto inputs = content::read_inputs(message.text, player_.content(), "inputs"); inputs)
        player_.schedule(std::move(*inputs));
      else
        problems = inputs.error();
    } else if (op == "recorded") {
      if (Result<Json> inputs = json::parse_json(content::write_inputs(player_.inputs(), player_.content()), "inputs"); inputs)
        result = std::move((*inputs)["inputs"]);
    } else if (op == "hash") {
      result = hex(player_.state_hash());
    } else {
      problems.add(ErrorCode::unknown, "message/op", "'" + op + "' is not an operation.", "Reload the page.");
    }
  }
  if (!wants_answer) return;
  Json answer = {{"event", "done"}, {"id", id}};
  if (problems.empty())
    answer["result"] = std::move(result);
  else
    answer["error"] = problems.text();
  outbox_->send(message.client, json::to_text(answer));
}

}  // namespace ugoki::player_native
