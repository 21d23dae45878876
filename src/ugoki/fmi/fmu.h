#pragma once
// An FMU file: its description, its LSIs and, once a circuit uses it, its code. Internal to fmi.

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

/// LsiClass::abi of an FMU's LSI points to an FmuClass. The base class is empty; the functions of the LSI are in fmu_lsi.cpp.
struct FmuClass : ugoki_class {
  Fmu* fmu = nullptr;
  Declaration declaration;
};

/// An FMU file. Its code is loaded when it is needed first.
class Fmu {
 public:
  /// Reads the file without running its code. Errors and parameters: see load_fmu.
  [[nodiscard]] static Result<std::shared_ptr<Fmu>> open(const std::string& path, std::string bytes, std::string hash, Phase phase);

  [[nodiscard]] const ModelDescription& description() const { return description_; }
  [[nodiscard]] const std::vector<std::string>& notes() const { return notes_; }
  [[nodiscard]] std::vector<FmuClass>& classes() { return classes_; }

  /// The FMU's code, which is loaded at the first call. Errors: the file has changed since it was opened; see Code::open.
  [[nodiscard]] Result<std::shared_ptr<Code>> code();
  /// Bytes to reserve for a saved state: twice the size that a started instance reports, and 1 KiB. 0: the FMU cannot save its state as
  /// bytes, or the state would exceed 64 MiB. The first call starts an instance and ends it.
  [[nodiscard]] std::size_t state_bytes();
  /// Starts an instance, initialises it and ends it. Error: one of these failed.
  [[nodiscard]] Result<void> attempt();

  int instances = 0;  ///< number of instances that exist now in this process

 private:
  Fmu() = default;
  /// Reports the phase "The FMU 'ball.fmu' was being WHAT" (see Phase), and its end.
  void begin(const char* what) const;
  void end() const;
  /// Starts and ends an instance. @param bytes [out] size of its serialised state; 0: none
  [[nodiscard]] Result<void> measure(std::size_t& bytes);

  std::string path_, hash_;
  Phase phase_ = nullptr;
  ModelDescription description_;
  std::vector<std::string> notes_;
  std::vector<FmuClass> classes_;
  std::optional<Result<std::shared_ptr<Code>>> code_;
  std::optional<std::size_t> state_bytes_;
};

/// Sets the functions (init, step, advance ...) of an LSI of an FMU.
void add_functions(circuit::LsiClass& lsi_class);

}  // namespace ugoki::fmi
