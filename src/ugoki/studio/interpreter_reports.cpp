// Members of Interpreter that report transport, devices, summary and measures to the pages.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "ugoki/circuit/devices.h"
#include "ugoki/studio/interpreter.h"
#include "ugoki/studio/recorded_joints.h"

namespace ugoki::studio {
namespace {

using Json = nlohmann::json;

constexpr std::size_t max_measures = 40'000;  // maximum count of values in one event `measures`, about 300 KB of text

/// `value` rounded to multiples of 0.001, which is finer than any limit of the measures and keeps their text short.
double rounded(float value) { return std::round(static_cast<double>(value) * 1000) / 1000; }

}  // namespace

void Interpreter::report_transport() {
  transport_reported_ = seconds_();
  const double pace = computed_seconds_ > 0 ? computed_steps_ / computed_seconds_ : 0;
  char hash[17];
  std::snprintf(hash, sizeof hash, "%016llx", static_cast<unsigned long long>(simulation_->state_hash()));
  const Json event{{"event", "transport"},
                   {"mode", mode_ == PlayMode::edit ? "edit" : "simulate"},
                   {"playing", playing_},
                   {"speed", speed_},
                   {"loop", loop_},
                   {"time", shown_},
                   {"duration", simulation_->duration()},
                   {"simulated", head_time()},
                   {"steps", simulation_->step_count()},
                   {"state_hash", hash},
                   {"steps_per_s", pace},
                   {"realtime_factor", pace * simulation_->step_size()},
                   {"status", status_}};
  sink_.message(event.dump(-1, ' ', false, Json::error_handler_t::replace));
}

/// Sends the event `devices` (what the circuit reads of keyboard, mouse and gamepads) if it changed.
void Interpreter::report_devices() {
  circuit::DeviceUse use = simulation_->devices() ? simulation_->devices()->use() : circuit::DeviceUse{};
  if (reported_devices_ == use) return;
  sink_.message(R"({"event":"devices",)" + circuit::write_device_use(use).substr(1));
  reported_devices_ = std::move(use);
}

void Interpreter::report_summary() {
  touches_reported_ = 0;
  report_quality();
  summary_reported_ = seconds_();
  summary_due_ = false;
  const std::vector<CastMember>& cast = simulation_->cast();
  Json characters = Json::array(), contacts = Json::array();
  for (std::size_t c = 0; c < cast.size(); ++c) {
    const CharacterSummary s = simulation_->summary(static_cast<int>(c));
    characters.push_back({{"id", cast[c].id},
                          {"assist_rms_bw", s.assist_rms_bw},
                          {"foot_skate_cm", s.foot_skate_cm},
                          {"tracking_rms_deg", s.tracking_rms_deg},
                          {"penetration_mm", s.penetration_mm},
                          {"fell", s.fell}});
  }
  for (const ContactStretch& s : recording_->contacts()) {
    contacts.push_back({{"character", cast[static_cast<std::size_t>(s.character)].id}, {"from", s.from}, {"to", s.to}, {"feet", s.feet}});
  }
  sink_.message(Json{{"event", "summary"}, {"characters", std::move(characters)}, {"contacts", std::move(contacts)}}.dump());
  report_measures();
}

Result<void> Interpreter::report_recorded(std::string_view character, const std::vector<std::string>& links) {
  if (Result<void> r = require_content(); !r) return r;
  const std::vector<CastMember>& cast = simulation_->cast();
  const auto found = std::ranges::find(cast, character, &CastMember::id);
  const std::vector<MechanismPtr> mechanisms = simulation_->mechanisms();
  const auto c = static_cast<std::size_t>(found - cast.begin());
  if (c >= mechanisms.size())
    return fail(ErrorCode::unknown, "character", "There is no character \"" + std::string(character) + "\".",
                "Give the id of one of the scenario's characters.");
  const Mechanism& m = *mechanisms[c];
  const std::size_t frames = recording_ ? recording_->frame_count() : 0;
  std::size_t values = 1;
  for (const std::string& name : links) {
    const int link = m.find_link(name);
    if (link < 0)
      return fail(ErrorCode::unknown, "links", "\"" + std::string(character) + "\" has no link \"" + name + "\".",
                  "Give names of its links.");
    values += frames * static_cast<std::size_t>(m.link(link).joint.nv());
  }
  const std::size_t stride = (values + max_measures - 1) / max_measures;
  Json curves = Json::array();
  for (const std::string& name : links) {
    const int index = m.find_link(name);
    const Link& link = m.link(index);
    if (link.joint.nv() == 0 || link.joint.type == JointType::floating) continue;
    std::vector<std::vector<double>> samples(static_cast<std::size_t>(link.joint.nv()));
    for (std::size_t n = 0; n < frames; n += stride) {
      const Pose X = link_pose(recording_->frame(n), c, index);
      const std::array<double, 6> x =
          displacement_of(link.joint, link.parent < 0 ? X : link_pose(recording_->frame(n), c, link.parent).inverse() * X);
      for (std::size_t k = 0; k < samples.size(); ++k) samples[k].push_back(x[k]);
    }
    Json components = Json::array();
    for (std::vector<double>& component : samples) {
      const bool turns = link.joint.type != JointType::prismatic && link.joint.type != JointType::spherical;
      if (turns && &component == &samples.front() && link.joint.type != JointType::planar) unwrap(component);
      Json rounded_values = Json::array();
      for (const double x : component) rounded_values.push_back(std::round(x * 1e5) / 1e5);
      components.push_back(std::move(rounded_values));
    }
    curves.push_back({{"link", name}, {"values", std::move(components)}});
  }
  const Json event{{"event", "recorded"},
                   {"character", character},
                   {"step", recording_ ? static_cast<double>(stride) / recording_->rate() : 0.0},
                   {"curves", std::move(curves)}};
  sink_.message(event.dump(-1, ' ', false, Json::error_handler_t::replace));
  return {};
}

void Interpreter::resend_measures() {
  measures_sent_ = 0;
  measures_cut_ = true;
  summary_due_ = true;
}

namespace {

Json limit(double x) { return std::isfinite(x) ? Json(x) : Json(nullptr); }

/// The measures with their limits, as pages show them.
Json measure_table() {
  Json out = Json::array();
  for (const naturalness::MeasureInfo& m : naturalness::measure_list())
    out.push_back({{"key", m.key},
                   {"name", m.name},
                   {"unit", m.unit},
                   {"total", naturalness::name_of(m.total)},
                   {"digits", m.digits},
                   {"low", limit(m.limits.low)},
                   {"good_low", limit(m.limits.good_low)},
                   {"good_high", limit(m.limits.good_high)},
                   {"high", limit(m.limits.high)},
                   {"now_low", limit(m.now.low)},
                   {"now_high", limit(m.now.high)},
                   {"smooth", m.smooth},
                   {"meaning", m.meaning}});
  return out;
}

}  // namespace

/// Sends the event `measures` with the frames that the pages do not have; if there are too many for one event, the rest is due later.
void Interpreter::report_measures() {
  const std::size_t frames = recording_->frame_count();
  if (!measures_cut_ && measures_sent_ == frames) return;
  const std::vector<CastMember>& cast = simulation_->cast();
  const std::size_t in_frame = naturalness::measure_count * std::max<std::size_t>(1, cast.size());
  const std::size_t end = std::min(frames, measures_sent_ + std::max<std::size_t>(1, max_measures / in_frame));
  Json characters = Json::array();
  for (std::size_t c = 0; c < cast.size(); ++c) {
    Json values = Json::object(), totals = Json::object();
    const RunMeasures run = simulation_->run_measures(static_cast<int>(c));
    for (const naturalness::MeasureInfo& info : naturalness::measure_list()) {
      const std::size_t k = naturalness::index_of(info.id);
      if (run[k] < 0)
        totals[info.key] = naturalness::reason_words(run[k]);
      else
        totals[info.key] = rounded(static_cast<float>(run[k]));
      Json series = Json::array();
      bool any = false;
      for (std::size_t n = measures_sent_; n < end; ++n) {
        const float value = recording_->measures(n)[c][k];
        any = any || value >= 0;
        series.push_back(value < 0 ? Json(nullptr) : Json(rounded(value)));
      }
      if (any) values[info.key] = std::move(series);
    }
    characters.push_back({{"id", cast[c].id}, {"values", std::move(values)}, {"totals", std::move(totals)}});
  }
  Json event{{"event", "measures"},
             {"rate", recording_->rate()},
             {"from", measures_sent_},
             {"frames", end - measures_sent_},
             {"characters", std::move(characters)}};
  if (measures_sent_ == 0) event["list"] = measure_table();
  sink_.message(event.dump());
  measures_sent_ = end;
  measures_cut_ = false;
  if (end < frames) summary_due_ = true;
}

}  // namespace ugoki::studio
