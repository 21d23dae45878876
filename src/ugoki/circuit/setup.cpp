#include "ugoki/circuit/setup.h"

#include <algorithm>

#include "ugoki/base/check.h"

namespace ugoki::circuit {
namespace {

std::size_t numbers_of(ParameterKind kind) { return kind == ParameterKind::text ? 0 : kind == ParameterKind::vector ? 3 : 1; }

}  // namespace

Setup::Setup(std::string id, std::string location, const LsiClass& lsi_class, std::vector<Value> parameters, const Resources* resources,
             double dt, Error& problems)
    : id_(std::move(id)),
      location_(std::move(location)),
      class_(&lsi_class),
      parameters_(std::move(parameters)),
      resources_(resources),
      dt_(dt),
      problems_(&problems),
      inputs_(lsi_class.inputs.size()),
      outputs_(lsi_class.outputs.size()) {
  for (std::size_t i = 0; i < outputs_.size(); ++i) {
    const OutputPin& pin = lsi_class.outputs[i];
    outputs_[i].count = pin.count ? pin.count : pin_type(pin.type).default_count;
  }
}

const Value& Setup::value(std::string_view parameter) const {
  const int i = class_->find_parameter(parameter);
  UGOKI_CHECK(i >= 0);
  return parameters_[static_cast<std::size_t>(i)];
}

double Setup::number(std::string_view parameter) const { return *std::get_if<double>(&value(parameter)); }
bool Setup::boolean(std::string_view parameter) const { return *std::get_if<bool>(&value(parameter)); }
const std::string& Setup::text(std::string_view parameter) const { return *std::get_if<std::string>(&value(parameter)); }

void Setup::set_out(std::size_t pin, std::uint32_t count, int subject) {
  UGOKI_CHECK(pin < outputs_.size());
  outputs_[pin] = {count, subject};
}

void Setup::follow_inputs() {
  for (std::size_t i = 0; i < outputs_.size(); ++i)
    if (const int like = class_->outputs[i].like; like >= 0) outputs_[i] = in(static_cast<std::size_t>(like));
}

std::string Setup::first_word() const {
  for (const Value& v : parameters_)
    if (const auto* word = std::get_if<std::string>(&v)) return *word;
  return {};
}

const void* Setup::find_resource(std::string_view kind, std::string_view name) {
  const void* found = resources_ ? resources_->find(kind, name) : nullptr;
  if (!found) {
    const std::string message =
        name.empty() ? "No " + std::string(kind) + " is given." : "There is no " + std::string(kind) + " '" + std::string(name) + "' here.";
    fail(ErrorCode::unknown, message,
         "Run the circuit with a content that has this " + std::string(kind) + ", or correct the parameter that names it.");
  }
  return found;
}

void Setup::fail(ErrorCode code, std::string message, std::string remedy) {
  problems_->add(code, location_, std::move(message), std::move(remedy));
}

std::vector<double> Setup::numbers() const {
  std::vector<double> out;
  for (std::size_t i = 0; i < parameters_.size(); ++i) {
    const Parameter& p = class_->parameters[i];
    const Value& v = parameters_[i];
    switch (p.kind) {
      case ParameterKind::number:
      case ParameterKind::integer: out.push_back(*std::get_if<double>(&v)); break;
      case ParameterKind::boolean: out.push_back(*std::get_if<bool>(&v) ? 1.0 : 0.0); break;
      case ParameterKind::text: break;
      case ParameterKind::choice:
        out.push_back(
            static_cast<double>(std::find(p.choices.begin(), p.choices.end(), *std::get_if<std::string>(&v)) - p.choices.begin()));
        break;
      case ParameterKind::vector: {
        const auto& x = *std::get_if<std::vector<double>>(&v);
        out.insert(out.end(), x.begin(), x.end());
        break;
      }
    }
  }
  return out;
}

std::size_t parameter_offset(const LsiClass& lsi_class, std::size_t index) {
  std::size_t offset = 0;
  for (std::size_t i = 0; i < index; ++i) offset += numbers_of(lsi_class.parameters[i].kind);
  return offset;
}

}  // namespace ugoki::circuit
