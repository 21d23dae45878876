#include "ugoki/studio/interpreter_child.h"

#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <cstdio>
#include <deque>
#include <limits>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "ugoki/circuit/class_json.h"
#include "ugoki/plugin/guard.h"
#include "ugoki/plugin/guard_block.h"
#include "ugoki/plugin/live_library.h"
#include "ugoki/studio/channel.h"
#include "ugoki/studio/error_json.h"
#include "ugoki/studio/frame_ring.h"
#include "ugoki/studio/interpreter.h"
#include "ugoki/studio/player_simulation.h"

namespace ugoki::studio {
namespace {

using Json = nlohmann::json;

double seconds_now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

class ChildSink final : public InterpreterSink {
 public:
  ChildSink(Channel& control, FrameRing& ring) : control_(control), ring_(ring) {}

  void frame(std::span<const std::byte> bytes) override {
    if (!ring_.write(bytes)) {
      if (!reported_)
        message(R"({"event":"log","level":"error","text":"The scene cannot be shown: a display frame is larger than 1 MiB. )"
                R"(Use fewer links or contacts."})");
      reported_ = true;
      return;
    }
    const std::uint64_t one = 1;
    // The write never blocks. It fails only if the eventfd's counter is full; then the reader has been signalled already.
    [[maybe_unused]] const ssize_t n = ::write(child_file::signal, &one, sizeof one);
  }
  void message(std::string json) override {
    if (!control_.send(json)) _exit(0);  // sending fails only if the studio has closed the socket
  }

 private:
  Channel& control_;
  FrameRing& ring_;
  bool reported_ = false;
};

/// Queue of messages from the studio. A thread reads them, and ends the process when the studio closes the socket, even if a step hangs.
class Inbox {
 public:
  explicit Inbox(Channel& control) {
    std::thread([this, &control] {
      while (std::optional<ChannelMessage> message = control.receive()) {
        const std::scoped_lock lock(mutex_);
        messages_.push_back(std::move(*message));
        arrived_.notify_one();
      }
      _exit(0);
    }).detach();
  }
  /// Removes and returns the next message; waits for it at most `seconds`.
  std::optional<ChannelMessage> take(double seconds) {
    std::unique_lock lock(mutex_);
    const auto some = [this] { return !messages_.empty(); };
    if (!some() && seconds > 0) arrived_.wait_for(lock, std::chrono::duration<double>(std::min(seconds, 3600.0)), some);
    if (!some()) return std::nullopt;
    ChannelMessage message = std::move(messages_.front());
    messages_.pop_front();
    return message;
  }

 private:
  std::mutex mutex_;
  std::condition_variable arrived_;
  std::deque<ChannelMessage> messages_;
};

// Value of a request's field, or a default if the field is missing. The studio has already checked the types of the fields.
std::string text_of(const Json& request, const char* key) {
  const auto it = request.find(key);
  return it != request.end() && it->is_string() ? it->get<std::string>() : std::string();
}
double number_of(const Json& request, const char* key, double otherwise = 0) {
  const auto it = request.find(key);
  return it != request.end() && it->is_number() ? it->get<double>() : otherwise;
}
Vec3 vec3_of(const Json& request, const char* key) {
  const auto it = request.find(key);
  if (it == request.end() || !it->is_array() || it->size() != 3) return {};
  const auto part = [&](std::size_t i) { return (*it)[i].is_number() ? (*it)[i].get<double>() : 0.0; };
  return {part(0), part(1), part(2)};
}

std::vector<std::string> texts_of(const Json& request, const char* key) {
  std::vector<std::string> out;
  if (const auto it = request.find(key); it != request.end() && it->is_array())
    for (const Json& text : *it)
      if (text.is_string()) out.push_back(text.get<std::string>());
  return out;
}

/// The event `lsis`: the LSI classes that circuits may use.
std::string lsis_event() {
  const std::string text = json::to_text(circuit::library_json(*lsi_library().library()));
  return "{\"event\":\"lsis\"," + text.substr(1);
}

Result<void> serve(Interpreter& interpreter, const Json& request, const std::vector<std::byte>& block) {
  const std::string op = text_of(request, "op");
  if (op == "ping") return {};
  if (op == "load") return interpreter.load(block);
  if (op == "mode") return interpreter.set_mode(text_of(request, "mode") == "simulate" ? PlayMode::simulate : PlayMode::edit);
  if (op == "play") return interpreter.play(request.contains("speed") ? std::optional(number_of(request, "speed")) : std::nullopt);
  if (op == "pause") return interpreter.pause();
  if (op == "step" && request.contains("ticks")) return interpreter.step_tick();
  if (op == "step") return interpreter.step_frames(static_cast<int>(number_of(request, "frames", 1)));
  if (op == "seek") return interpreter.seek(number_of(request, "time"));
  if (op == "restart") {
    // Global variables of LSIs get their initial values again, so that the restarted content gives the same results.
    if (lsi_library().renew()) (void)interpreter.change_library();
    return interpreter.restart();
  }
  if (op == "drag") return interpreter.drag(vec3_of(request, "target"));
  if (op == "release") return interpreter.release();
  if (op == "forget_pull") return interpreter.forget_pull(number_of(request, "time"));
  if (op == "input") {
    const Result<circuit::DeviceChange> change = circuit::read_device_change(request.dump());
    return change ? interpreter.input(*change) : fail(change.error());
  }
  if (op == "watch") {
    interpreter.watch({texts_of(request, "pins"), texts_of(request, "probes"), request.value("timing", false),
                       request.value("closest", request.value("nearest", false))});
    return {};
  }
  if (op == "recorded") return interpreter.report_recorded(text_of(request, "character"), texts_of(request, "links"));
  if (op == "range") {
    constexpr double never = std::numeric_limits<double>::infinity();
    interpreter.set_range(number_of(request, "from"), number_of(request, "to", never), request.value("loop", false));
    return {};
  }
  if (op == "measures") {
    interpreter.resend_measures();
    return {};
  }
  if (op == "breakpoints") {
    interpreter.set_breakpoints(texts_of(request, "conditions"));
    return {};
  }
  const std::string character = text_of(request, "character"), link = text_of(request, "link");
  if (op == "grab") return interpreter.grab(character, link, vec3_of(request, "point"), vec3_of(request, "target"));
  if (op == "push") return interpreter.push(character, link, vec3_of(request, "force"), number_of(request, "duration"));
  return fail(ErrorCode::unknown, "op", "The interpreter has no operation \"" + op + "\".", "This is an error in Ugoki; please report it.");
}

}  // namespace

int run_interpreter(SimulationOpener opener) {
  constexpr double library_period = 0.25;  // time between two checks for changed LSI libraries, s
  std::signal(SIGPIPE, SIG_IGN);
  (void)plugin::attach_guard_block(child_file::guard);
  plugin::guard_process(child_file::words);
  Result<FrameRing> ring = FrameRing::attach(child_file::frames);
  if (!ring) {
    std::fprintf(stderr, "%s\n", ring.error().text().c_str());
    return 1;
  }
  // Static, because the reading thread uses them until the process ends (always by _exit).
  static Channel control(child_file::control);
  static Inbox inbox(control);
  ChildSink sink(control, *ring);
  Interpreter interpreter(opener, sink, seconds_now);
  const auto log = [&sink](std::string_view level, const std::string& text) {
    sink.message(Json{{"event", "log"}, {"level", level}, {"text", text}}.dump(-1, ' ', false, Json::error_handler_t::replace));
  };
  const auto report_library = [&] {
    for (const std::string& problem : lsi_library().take_messages()) log("error", problem);
    sink.message(lsis_event());
  };
  report_library();
  double wait = 0, last_poll = seconds_now();
  while (true) {
    if (seconds_now() - last_poll >= library_period) {
      last_poll = seconds_now();
      if (lsi_library().poll()) {
        for (const std::string& sentence : interpreter.change_library()) log("info", sentence);
        report_library();
      }
      for (const std::string& text : lsi_library().take_messages()) log("info", text);  // messages of running FMUs
    }
    while (std::optional<ChannelMessage> message = inbox.take(std::min(wait, library_period))) {
      wait = 0;
      const Json request = Json::parse(message->text, nullptr, false);
      const Result<void> done = serve(interpreter, request, message->block);
      const auto id = request.find("request");
      if (id == request.end()) continue;
      std::string reply = "{\"reply\":" + id->dump() + ",\"ok\":" + (done ? "true" : "false");
      if (!done) reply += ",\"error\":" + error_json(done.error());
      sink.message(reply + "}");
    }
    wait = interpreter.work();
  }
}

}  // namespace ugoki::studio
