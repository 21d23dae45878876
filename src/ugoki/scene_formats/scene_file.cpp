// Reads scene files in a guarded child process, which serialises its result as an answer; the calling process parses this answer.

#include "ugoki/scene_formats/scene_file.h"

#include <cstdint>
#include <string>

#include "ugoki/formats/motion_binary.h"
#include "ugoki/scene_formats/guarded_answer.h"
#include "ugoki/scene_formats/guarded_call.h"

namespace ugoki::scene_formats {
namespace {

/// Runs in the child process: reads the file and serialises the motions and notes, or the problems.
std::string answer_of(std::span<const std::byte> bytes, std::string_view file_name, const SceneOptions& options) {
  formats::ReadNotes notes;
  const Result<std::vector<MeasuredMotion>> motions = read_scene_unguarded(bytes, file_name, options, notes);
  std::string out;
  if (!motions) {
    put_number(out, std::uint64_t{0});
    put_error(out, motions.error());
    return out;
  }
  put_number(out, std::uint64_t{motions->size()});
  put_number(out, notes.frame_time);
  put_number(out, notes.metres_per_unit);
  put_number(out, std::uint64_t{notes.unit_guessed} + 2 * std::uint64_t{notes.z_up});
  put_number(out, std::uint64_t{notes.remarks.size()});
  for (const std::string& remark : notes.remarks) put(out, remark);
  for (const MeasuredMotion& m : *motions) {
    const std::vector<std::byte> data = formats::write_measured_motion(m);
    put(out, {reinterpret_cast<const char*>(data.data()), data.size()});
  }
  return out;
}

/// Parses an answer of answer_of(). Returns false if the answer is damaged, which can happen if the child's memory was corrupted.
bool parse_answer(std::string_view in, const std::string& location, Error& error, std::vector<MeasuredMotion>& motions,
                  formats::ReadNotes& notes) {
  std::uint64_t count = 0, flags = 0, remarks = 0;
  std::string_view text;
  if (!take_number(in, count)) return false;
  if (count == 0) return take_error(in, error);
  if (!take_number(in, notes.frame_time) || !take_number(in, notes.metres_per_unit) || !take_number(in, flags) || !take_number(in, remarks))
    return false;
  notes.unit_guessed = (flags & 1) != 0;
  notes.z_up = (flags & 2) != 0;
  for (std::uint64_t i = 0; i < remarks; ++i) {
    if (!take(in, text)) return false;
    notes.remarks.emplace_back(text);
  }
  for (std::uint64_t i = 0; i < count; ++i) {
    if (!take(in, text)) return false;
    Result<MeasuredMotion> motion = formats::read_measured_motion({reinterpret_cast<const std::byte*>(text.data()), text.size()}, location);
    if (!motion) return false;
    motions.push_back(std::move(*motion));
  }
  return true;
}

}  // namespace

Result<std::vector<MeasuredMotion>> read_scene(std::span<const std::byte> bytes, std::string_view file_name, const SceneOptions& options,
                                               formats::ReadNotes* notes) {
  const Result<std::string> answer =
      call_guarded([&] { return answer_of(bytes, file_name, options); }, file_name, {.seconds = options.seconds});
  if (!answer) return fail(answer.error());
  Error error;
  std::vector<MeasuredMotion> motions;
  formats::ReadNotes read_notes;
  if (!parse_answer(*answer, std::string(file_name), error, motions, read_notes))
    return fail(ErrorCode::syntax, std::string(file_name),
                "The library that reads this format returned an incomplete answer: the file is damaged.", "Export it again.");
  if (!error.empty()) return fail(std::move(error));
  if (notes) *notes = std::move(read_notes);
  return motions;
}

}  // namespace ugoki::scene_formats
