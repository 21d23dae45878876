#include <cmath>
#include <cstdint>

#include "ugoki/base/number.h"
#include "ugoki/formats/bvh.h"
#include "ugoki/formats/bvh_hierarchy.h"

namespace ugoki::formats {
namespace {

constexpr const char* cut_off_remedy = "The file was cut off; export or copy it again.";

struct MotionHeader {
  std::size_t frames = 0;
  double frame_time = 0;
  double rate = 0;
};

std::optional<MotionHeader> read_motion_header(Scanner& scanner, Problems& problems) {
  MotionHeader header;
  if (!scanner.accept("Frames")) {
    const bool ended = !scanner.skip_space();
    problems.add(ended ? ErrorCode::truncated : ErrorCode::syntax, scanner.line(), "'Frames:' is missing after MOTION.",
                 ended ? cut_off_remedy : "Add a line 'Frames: N'.");
    return std::nullopt;
  }
  scanner.accept_on_line(':');
  std::string_view token = scanner.word_on_line();
  const auto frames = parse_long(token);
  if (!frames || *frames < 1) {
    problems.add(token.empty() ? ErrorCode::truncated : ErrorCode::range, scanner.line(),
                 frames ? "The number of frames is " + std::to_string(*frames) + "; it must be at least 1."
                        : "'Frames:' is followed by " + in_quotes(token) + " instead of an integer.",
                 "Write the number of frames that follow.");
    return std::nullopt;
  }
  header.frames = static_cast<std::size_t>(*frames);
  bool timed = scanner.accept("Frame Time");
  if (!timed && scanner.accept("Frame")) timed = scanner.accept("Time");
  if (!timed) {
    const bool ended = !scanner.skip_space();
    problems.add(ended ? ErrorCode::truncated : ErrorCode::syntax, scanner.line(), "'Frame Time:' is missing after 'Frames:'.",
                 ended ? cut_off_remedy : "Add a line 'Frame Time: S' with the time between frames in seconds.");
    return std::nullopt;
  }
  scanner.accept_on_line(':');
  token = scanner.word_on_line();
  const auto time = measured_number(token);
  // Accepted frame rates: one frame an hour to 1 MHz. Both limits are far beyond any recording.
  if (!time || *time < 1e-6 || *time > 3600) {
    NumberFault fault{ErrorCode::range, "The frame time is " + in_quotes(token) + "; it must be between 1e-6 and 3600 s.",
                      "Write the time between two frames in seconds, for example 0.0083333 for 120 frames per second."};
    if (token.empty()) fault = {ErrorCode::truncated, "'Frame Time:' has no value.", fault.remedy};
    problems.add(fault.code, scanner.line(), fault.message, fault.remedy);
    return std::nullopt;
  }
  header.frame_time = *time;
  header.rate = rate_of(*time, token);
  return header;
}

/// Reads the values of all frames, [frames][channels], in file units and degrees.
std::optional<std::vector<double>> read_numbers(Scanner& scanner, std::size_t frames, std::size_t channels, std::size_t joints,
                                                Problems& problems) {
  const int header_line = scanner.line();
  const std::string declared = "'Frames:' announces " + std::to_string(frames) + " frames of " + std::to_string(channels) + " values";
  // A value takes at least two characters, a digit and a separator. Check that the announced values can fit into the rest of the
  // text before memory is allocated for them.
  if (frames > max_numbers / channels || frames * channels > scanner.remaining() / 2 + 1) {
    problems.add(ErrorCode::truncated, header_line, declared + ", but the rest of the file is too short for them.",
                 "Correct the number after 'Frames:', or export the file again.");
    return std::nullopt;
  }
  const std::size_t count = frames * channels;
  // Joints without channels take memory in every frame but no text. Limit: a million joint poses, plus 8 for each value in the text, so
  // that memory stays proportional to the file's size.
  if (std::uint64_t{frames} * joints > std::uint64_t{1'000'000} + std::uint64_t{8} * count) {
    problems.add(ErrorCode::range, header_line, "Almost all of the " + std::to_string(joints) + " joints have no channels.",
                 "Remove joints that never move.");
    return std::nullopt;
  }
  std::vector<double> numbers;
  numbers.reserve(count);
  int line = -1, odd_line = 0;
  std::size_t on_line = 0, odd_count = 0;
  const auto end_line = [&] {
    if (line >= 0 && odd_line == 0 && on_line != channels) {
      odd_line = line;
      odd_count = on_line;
    }
  };
  std::size_t surplus = 0;
  while (scanner.skip_space()) {
    if (scanner.line() != line) {
      end_line();
      line = scanner.line();
      on_line = 0;
    }
    const std::string_view token = scanner.word_on_line();
    const auto value = measured_number(token);
    if (!value) {
      const NumberFault fault = number_fault(token);
      problems.add(fault.code, scanner.line(), fault.message, fault.remedy);
      if (problems.full()) return std::nullopt;
    }
    ++on_line;
    if (numbers.size() < count)
      numbers.push_back(value.value_or(0));
    else
      ++surplus;
  }
  end_line();
  if (!problems.empty()) return std::nullopt;
  if (numbers.size() == count && surplus == 0) return numbers;
  const std::size_t found = numbers.size() + surplus;
  if (odd_line > 0 && odd_line != line)
    problems.add(ErrorCode::structure, odd_line,
                 "This line has " + std::to_string(odd_count) + " values, but a frame has " + std::to_string(channels) + ".",
                 "Correct the line, or the CHANNELS of the joints.");
  else if (surplus > 0)
    problems.add(ErrorCode::structure, scanner.line(), declared + ", but there are " + std::to_string(found) + " values.",
                 found % channels == 0 ? "Write 'Frames: " + std::to_string(found / channels) + "', or remove the extra frames."
                                       : "Remove the extra values.");
  else
    problems.add(ErrorCode::truncated, scanner.line(),
                 declared + ", but the file ends after " + std::to_string(found / channels) + " frames and " +
                     std::to_string(found % channels) + " values.",
                 found >= channels ? "Export the file again, or write 'Frames: " + std::to_string(found / channels) +
                                         "' and remove an incomplete last frame."
                                   : cut_off_remedy);
  return std::nullopt;
}

/// Returns the unit of length, m per file unit, from the options. If the options specify none, it is guessed from the skeleton's size.
double choose_unit(const Skeleton& skeleton, const BvhOptions& options, ReadNotes& notes) {
  notes.unit_guessed = !(options.metres_per_unit > 0) || !std::isfinite(options.metres_per_unit);
  if (!notes.unit_guessed) return options.metres_per_unit;
  const double extent = rest_extent(skeleton);
  const UnitGuess guess = guess_unit(extent);
  std::string remark = "Lengths are assumed to be in " + guess.name + ": the largest extent of the skeleton at rest is " +
                       to_fixed(extent, 3) + " units, " + to_fixed(extent * guess.metres, 3) + " m.";
  if (!guess.plausible) remark += " This is not the size of a person (1 to 2.5 m); set the unit of length if it is wrong.";
  notes.remarks.push_back(std::move(remark));
  return guess.metres;
}

}  // namespace

Result<MeasuredMotion> read_bvh(std::string_view text, std::string_view file_name, const BvhOptions& options, ReadNotes* notes) {
  Problems problems(file_name);
  const auto plain = plain_text(text, "BVH", problems);
  if (!plain) return fail(problems.take());
  Scanner scanner(*plain);
  const FileAxes axes{options.z_up};
  auto hierarchy = read_bvh_hierarchy(scanner, axes, problems);
  if (!hierarchy) return fail(problems.take());
  const auto header = read_motion_header(scanner, problems);
  if (!header) return fail(problems.take());
  const std::size_t channels = hierarchy->channels.size(), joints = hierarchy->skeleton.joints.size();
  const auto numbers = read_numbers(scanner, header->frames, channels, joints, problems);
  if (!numbers) return fail(problems.take());

  ReadNotes collected;
  collected.frame_time = header->frame_time;
  collected.remarks = std::move(hierarchy->remarks);
  const double unit = choose_unit(hierarchy->skeleton, options, collected);
  collected.metres_per_unit = unit;
  collected.z_up = options.z_up;

  MeasuredMotion motion;
  motion.name = stem_of(file_name);
  motion.source = std::string(file_name);
  motion.skeleton = std::move(hierarchy->skeleton);
  motion.skeleton.name = motion.name;
  motion.skeleton.unit = unit;
  motion.rate = header->rate;
  motion.frames = static_cast<int>(header->frames);
  for (SkeletonJoint& j : motion.skeleton.joints) {
    j.offset *= unit;
    for (Vec3& e : j.end_sites) e *= unit;
  }
  motion.translations.resize(header->frames * joints);
  motion.rotations.resize(header->frames * joints);
  const double* number = numbers->data();
  for (std::size_t f = 0; f < header->frames; ++f) {
    Vec3* translation = motion.translations.data() + f * joints;
    Quat* rotation = motion.rotations.data() + f * joints;
    for (std::size_t i = 0; i < joints; ++i) translation[i] = motion.skeleton.joints[i].offset;
    for (const BvhChannel& c : hierarchy->channels) {
      const auto i = static_cast<std::size_t>(c.joint);
      if (c.rotation)
        rotation[i] = rotation[i] * axis_angle(axes.unit(c.axis), *number * (pi / 180));
      else
        translation[i][axes.ours(c.axis)] = *number * unit;
      ++number;
    }
    for (std::size_t i = 0; i < joints; ++i) rotation[i] = normalized(rotation[i]);
  }
  if (notes) *notes = std::move(collected);
  return motion;
}

}  // namespace ugoki::formats
