#pragma once
// Checks of the files that a verb (subcommand of ugoki) will write, before the verb reads or computes anything.

#include <string>
#include <string_view>
#include <vector>

#include "sources.h"
#include "ugoki/base/result.h"

namespace ugoki::cli {

/// A file that a verb reads or writes, and the option or argument that names it.
struct NamedFile {
  std::string option;  ///< for example "--csv" or "the input"
  std::string path;    ///< empty: the option was not given
};

/// Refuses outputs that would destroy data: an output must not be an input, a file noted by note_read(), another output, or an existing
/// project or library of Ugoki. Two paths name the same file if device and inode are equal, or if the paths are equal after symbolic links
/// are followed. Inputs that are entries of the library, and outputs that are devices (/dev/null), are not compared.
/// Error: code `conflict`, the location is the path of the output.
[[nodiscard]] Result<void> check_outputs(const std::vector<NamedFile>& inputs, const std::vector<NamedFile>& outputs);

/// Checks the pictures of a numbered sequence. Most of them do not exist yet; only pictures that exist, or that another output also names,
/// are passed to check_outputs(). @param pictures paths of all pictures @param others the other outputs
[[nodiscard]] Result<void> check_pictures(const std::vector<NamedFile>& inputs, const std::vector<NamedFile>& others,
                                          const std::vector<std::string>& pictures);

/// Refuses to replace the file `path`, whose name the user has not given, unless Ugoki has written it. @param mark text that the files of
/// this kind contain
[[nodiscard]] Result<void> check_derived(const std::string& path, std::string_view mark);

/// Notes a file to which an input refers (a mesh, a buffer, the loops of a robot), so that later calls of check_outputs() protect it.
void note_read(const std::string& path);

/// The files that a verb reads for its argument `target`: the target, its skeleton if it is an AMC file, and the files in `options`.
[[nodiscard]] std::vector<NamedFile> input_files(const std::string& target, const SourceOptions& options);
[[nodiscard]] std::vector<NamedFile> input_files(const std::vector<std::string>& targets, const SourceOptions& options);

}  // namespace ugoki::cli
