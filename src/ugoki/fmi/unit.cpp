#include "ugoki/fmi/unit.h"

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>

#include "ugoki/fmi/messages.h"

namespace ugoki::fmi {
namespace {

constexpr int max_noted = 200;                   // maximum number of messages of one instance that are shown
constexpr std::size_t max_message_bytes = 2000;  // maximum size of a message; longer messages are cut
constexpr int max_rounds = 1000;                 // calls of UpdateDiscreteStates at one event; more count as an endless loop

/// The functions that have the same name and parameters in both versions of the standard. @tparam last last status of the version's enum
template <class Functions, class ForeignStatus, ForeignStatus last>
class UnitOf : public Unit {
 public:
  UnitOf(std::shared_ptr<Code> code, const ModelDescription& d, std::string name, bool logging, const Functions& functions)
      : Unit(std::move(code), d, std::move(name), logging), f_(functions) {}

  Status exit_initialization() override { return as(f_.ExitInitializationMode(instance_)); }
  Status reset() override { return as(f_.Reset(instance_)); }
  void terminate() override { (void)f_.Terminate(instance_); }
  void free() override {
    if (instance_) f_.FreeInstance(instance_);
    instance_ = nullptr;
  }
  void abandon() override { instance_ = nullptr; }

 protected:
  /// A status of the FMU; invalid values are errors.
  static Status as(ForeignStatus status) {
    return status >= ForeignStatus{} && status <= last ? static_cast<Status>(status) : Status::error;
  }

  const Functions& f_;
  void* instance_ = nullptr;
};

class Unit2 final : public UnitOf<Functions2, fmi2Status, fmi2Pending> {
 public:
  Unit2(std::shared_ptr<Code> code, const ModelDescription& d, std::string name, bool logging)
      : UnitOf(code, d, std::move(name), logging, code->two()) {}
  ~Unit2() override { free(); }  // not in the base class: freeing may call log(), which needs this object

  bool instantiate() override {
    instance_ =
        f_.Instantiate(name_.c_str(), fmi2CoSimulation, description_.token.c_str(), code_->resources().c_str(), &callbacks_, 0, logging_);
    if (instance_ && logging_) (void)f_.SetDebugLogging(instance_, 1, 0, nullptr);
    return instance_ != nullptr;
  }
  Status enter_initialization(double start) override {
    const Status status = as(f_.SetupExperiment(instance_, 0, 0, start, 0, 0));
    return status <= Status::warning ? as(f_.EnterInitializationMode(instance_)) : status;
  }
  Status step(double now, double size, StepEnd& end) override {
    end.status = as(f_.DoStep(instance_, now, size, 1));
    end.reached = now + size;
    if (end.status != Status::discard) return end.status;
    fmi2Boolean terminated = 0;
    if (f_.GetBooleanStatus(instance_, fmi2Terminated, &terminated) == fmi2OK) end.terminated = terminated != 0;
    double reached = now;
    if (f_.GetRealStatus(instance_, fmi2LastSuccessfulTime, &reached) == fmi2OK) end.reached = reached;
    return end.status;
  }

  Status set(Storage storage, std::span<const ValueReference> r, const void* values, std::size_t) override {
    switch (storage) {
      case Storage::i32: return as(f_.SetInteger(instance_, r.data(), r.size(), static_cast<const int*>(values)));
      case Storage::b32: return as(f_.SetBoolean(instance_, r.data(), r.size(), static_cast<const int*>(values)));
      default: return as(f_.SetReal(instance_, r.data(), r.size(), static_cast<const double*>(values)));
    }
  }
  Status get(Storage storage, std::span<const ValueReference> r, void* values, std::size_t) override {
    switch (storage) {
      case Storage::i32: return as(f_.GetInteger(instance_, r.data(), r.size(), static_cast<int*>(values)));
      case Storage::b32: return as(f_.GetBoolean(instance_, r.data(), r.size(), static_cast<int*>(values)));
      default: return as(f_.GetReal(instance_, r.data(), r.size(), static_cast<double*>(values)));
    }
  }
  Status set_text(ValueReference reference, const char* text) override { return as(f_.SetString(instance_, &reference, 1, &text)); }

  Status get_state(void*& state) override { return as(f_.GetFMUstate(instance_, &state)); }
  Status set_state(void* state) override { return as(f_.SetFMUstate(instance_, state)); }
  void free_state(void*& state) override { (void)f_.FreeFMUstate(instance_, &state); }
  Status serialized_size(void* state, std::size_t& bytes) override { return as(f_.SerializedFMUstateSize(instance_, state, &bytes)); }
  Status serialize(void* state, std::span<std::byte> bytes) override {
    return as(f_.SerializeFMUstate(instance_, state, reinterpret_cast<fmi2Byte*>(bytes.data()), bytes.size()));
  }
  Status deserialize(std::span<const std::byte> bytes, void*& state) override {
    return as(f_.DeSerializeFMUstate(instance_, reinterpret_cast<const fmi2Byte*>(bytes.data()), bytes.size(), &state));
  }

 private:
  static void log(fmi2ComponentEnvironment self, fmi2String, fmi2Status status, fmi2String category, fmi2String format, ...) {
    if (!self || !format) return;
    char text[max_message_bytes];
    va_list arguments;
    va_start(arguments, format);
    const int n = std::vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    static_cast<Unit2*>(self)->note(as(status), category, n < 0 ? format : text);
  }

  fmi2CallbackFunctions callbacks_{log, std::calloc, std::free, nullptr, this};
};

class Unit3 final : public UnitOf<Functions3, fmi3Status, fmi3Fatal> {
 public:
  Unit3(std::shared_ptr<Code> code, const ModelDescription& d, std::string name, bool logging)
      : UnitOf(code, d, std::move(name), logging, code->three()) {}
  ~Unit3() override { free(); }

  bool instantiate() override {
    instance_ = f_.InstantiateCoSimulation(name_.c_str(), description_.token.c_str(), code_->resources().c_str(), false, logging_,
                                           has_events(), has_events(), nullptr, 0, this, log, nullptr);
    if (instance_ && logging_) (void)f_.SetDebugLogging(instance_, true, 0, nullptr);
    return instance_ != nullptr;
  }
  Status enter_initialization(double start) override { return as(f_.EnterInitializationMode(instance_, false, 0, start, false, 0)); }
  Status step(double now, double size, StepEnd& end) override {
    bool event = false, terminate = false, early = false;
    double reached = now + size;
    end.status = as(f_.DoStep(instance_, now, size, true, &event, &terminate, &early, &reached));
    end.terminated = terminate;
    end.event = event;
    end.reached = early || end.status == Status::discard ? reached : now + size;
    return end.status;
  }
  bool has_events() const override { return description_.event_mode; }
  Status enter_events() override { return as(f_.EnterEventMode(instance_)); }
  Status finish_events(EventEnd& end) override {
    bool again = has_events();
    if (!again) return Status::ok;
    Status worst = Status::ok;
    for (int round = 0; again; ++round) {
      if (round == max_rounds) {
        note(Status::error, "", "Its events do not end (" + std::to_string(max_rounds) + " rounds of UpdateDiscreteStates).");
        return Status::error;
      }
      bool terminate = false, nominals = false, states = false, has_next = false;
      double next = 0;
      again = false;
      const Status status = as(f_.UpdateDiscreteStates(instance_, &again, &terminate, &nominals, &states, &has_next, &next));
      if (status > Status::warning) return status;
      worst = std::max(worst, status);
      end.next = has_next ? next : std::numeric_limits<double>::infinity();
      end.terminated = terminate;
      if (terminate) return worst;
    }
    return std::max(worst, as(f_.EnterStepMode(instance_)));
  }

  Status set(Storage storage, std::span<const ValueReference> r, const void* values, std::size_t count) override {
    const auto call = [&]<class T>(fmi3Status (*function)(fmi3Instance, const fmi3ValueReference*, std::size_t, const T*, std::size_t)) {
      return as(function(instance_, r.data(), r.size(), static_cast<const T*>(values), count));
    };
    switch (storage) {
      case Storage::f64: return call(f_.SetFloat64);
      case Storage::f32: return call(f_.SetFloat32);
      case Storage::i8: return call(f_.SetInt8);
      case Storage::u8: return call(f_.SetUInt8);
      case Storage::i16: return call(f_.SetInt16);
      case Storage::u16: return call(f_.SetUInt16);
      case Storage::i32: return call(f_.SetInt32);
      case Storage::u32: return call(f_.SetUInt32);
      case Storage::i64: return call(f_.SetInt64);
      case Storage::u64: return call(f_.SetUInt64);
      case Storage::b8:
      case Storage::b32: break;
    }
    return call(f_.SetBoolean);
  }
  Status get(Storage storage, std::span<const ValueReference> r, void* values, std::size_t count) override {
    const auto call = [&]<class T>(fmi3Status (*function)(fmi3Instance, const fmi3ValueReference*, std::size_t, T*, std::size_t)) {
      return as(function(instance_, r.data(), r.size(), static_cast<T*>(values), count));
    };
    switch (storage) {
      case Storage::f64: return call(f_.GetFloat64);
      case Storage::f32: return call(f_.GetFloat32);
      case Storage::i8: return call(f_.GetInt8);
      case Storage::u8: return call(f_.GetUInt8);
      case Storage::i16: return call(f_.GetInt16);
      case Storage::u16: return call(f_.GetUInt16);
      case Storage::i32: return call(f_.GetInt32);
      case Storage::u32: return call(f_.GetUInt32);
      case Storage::i64: return call(f_.GetInt64);
      case Storage::u64: return call(f_.GetUInt64);
      case Storage::b8:
      case Storage::b32: break;
    }
    return call(f_.GetBoolean);
  }
  Status set_text(ValueReference reference, const char* text) override { return as(f_.SetString(instance_, &reference, 1, &text, 1)); }

  Status get_state(void*& state) override { return as(f_.GetFMUState(instance_, &state)); }
  Status set_state(void* state) override { return as(f_.SetFMUState(instance_, state)); }
  void free_state(void*& state) override { (void)f_.FreeFMUState(instance_, &state); }
  Status serialized_size(void* state, std::size_t& bytes) override { return as(f_.SerializedFMUStateSize(instance_, state, &bytes)); }
  Status serialize(void* state, std::span<std::byte> bytes) override {
    return as(f_.SerializeFMUState(instance_, state, reinterpret_cast<fmi3Byte*>(bytes.data()), bytes.size()));
  }
  Status deserialize(std::span<const std::byte> bytes, void*& state) override {
    return as(f_.DeserializeFMUState(instance_, reinterpret_cast<const fmi3Byte*>(bytes.data()), bytes.size(), &state));
  }

 private:
  static void log(fmi3InstanceEnvironment self, fmi3Status status, fmi3String category, fmi3String text) {
    if (self && text) static_cast<Unit3*>(self)->note(as(status), category, text);
  }
};

}  // namespace

Unit::Unit(std::shared_ptr<Code> code, const ModelDescription& description, std::string name, bool logging)
    : code_(std::move(code)), description_(description), name_(std::move(name)), logging_(logging) {}

std::unique_ptr<Unit> Unit::make(std::shared_ptr<Code> code, const ModelDescription& d, std::string name, bool logging) {
  if (d.version == 2) return std::make_unique<Unit2>(std::move(code), d, std::move(name), logging);
  return std::make_unique<Unit3>(std::move(code), d, std::move(name), logging);
}

void Unit::note(Status status, const char* category, const std::string& raw) {
  std::string text = raw.substr(0, max_message_bytes);
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
  if (status != Status::ok) last_words_ = text;
  if ((status == Status::ok && !logging_) || noted_ > max_noted) return;
  if (noted_++ == max_noted) return post_message("Further messages of '" + name_ + "' are not shown.");
  constexpr const char* names[] = {"", "warning: ", "discarded: ", "error: ", "fatal: ", "pending: "};
  post_message("'" + name_ + "' reports: " + names[static_cast<std::size_t>(status)] + text +
               (category && *category ? " (" + std::string(category) + ")" : ""));
}

}  // namespace ugoki::fmi
