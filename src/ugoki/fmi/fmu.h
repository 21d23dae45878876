#pragma once
// An FMU file, its LSIs, and its code once it is needed. Internal to fmi.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "ugoki/fmi/code.h"
#include "ugoki/fmi/declare.h"
#include "ugoki/fmi/load.h"
#include "ugoki/fmi/unit.h"

namespace ugoki::fmi {

class Fmu;

/// What LsiClass::abi of an FMU's LSI points to.
struct FmuClass : ugoki_class {
  Fmu* fmu = nullptr;
  Declaration declaration;
};

class Fmu {
 public:
  [[nodiscard]] static Result<std::shared_ptr<Fmu>> open(const std::string& path, std::string bytes, std::string hash, Phase phase);

  [[nodiscard]] const ModelDescription& description() const { return description_; }
  [[nodiscard]] const std::vector<std::string>& notes() const { return notes_; }
  [[nodiscard]] std::vector<FmuClass>& classes() { return classes_; }

  /// Loads the code at the first call.
  [[nodiscard]] Result<std::shared_ptr<Code>> code();
  /// Bytes that its saved state takes, with room to grow; 0: it cannot be saved as bytes. Starts the FMU once to ask it.
  [[nodiscard]] std::size_t state_bytes();
  /// Starts and ends an instance.
  [[nodiscard]] Result<void> attempt();

  int instances = 0;  ///< alive now

 private:
  Fmu() = default;
  void begin(const char* what) const;
  void end() const;
  [[nodiscard]] Result<void> measure(std::size_t& bytes);

  std::string path_, hash_;
  Phase phase_ = nullptr;
  ModelDescription description_;
  std::vector<std::string> notes_;
  std::vector<FmuClass> classes_;
  std::optional<Result<std::shared_ptr<Code>>> code_;
  std::optional<std::size_t> state_bytes_;
};

/// Gives an LSI of an FMU its functions.
void add_functions(circuit::LsiClass& lsi_class);

}  // namespace ugoki::fmi
