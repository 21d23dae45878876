#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>

#include "ugoki/base/number.h"
#include "ugoki/formats/asf.h"
#include "ugoki/formats/file_axes.h"
#include "ugoki/formats/text.h"

namespace ugoki::formats {
namespace {

class AmcReader {
 public:
  AmcReader(std::string_view text, const Asf& asf, double rate, Problems& problems)
      : scanner_(text), text_size_(text.size()), asf_(asf), rate_(rate), problems_(problems), degrees_(asf.degrees) {
    for (std::size_t i = 0; i < asf.bones.size(); ++i) {
      index_.emplace(asf.bones[i].name, i);
      first_.push_back(values_per_frame_);
      values_per_frame_ += asf.bones[i].dofs.size();
    }
  }

  bool read() {
    while (!problems_.full() && scanner_.skip_space()) {
      const std::string_view word = scanner_.peek();
      if (word.starts_with('#')) {
        scanner_.rest_of_line();
      } else if (word.starts_with(':')) {
        if (!read_header(word)) return false;
      } else if (const char c = word[0]; (c >= '0' && c <= '9') || c == '-' || c == '+') {
        if (!begin_frame()) return false;
      } else if (!read_bone()) {
        return false;
      }
    }
    if (!problems_.empty() || !end_frame()) return false;
    if (frame_lines_.empty()) {
      problems_.add(ErrorCode::truncated, scanner_.line(), "The file has no frames.", "Export or copy it again.");
      return false;
    }
    return true;
  }

  /// Computes the poses of all frames and interpolates the missing ones. Call after read() has returned true.
  void evaluate(MeasuredMotion& motion) const {
    const std::size_t joints = asf_.skeleton.joints.size();
    const std::size_t frames = frame_lines_.size();
    const double angle_unit = degrees_ ? pi / 180 : 1;
    motion.rate = rate_;
    const std::size_t total = static_cast<std::size_t>(numbers_.back() - numbers_.front() + 1);
    motion.frames = static_cast<int>(total);
    motion.translations.resize(total * joints);
    motion.rotations.resize(total * joints);
    std::size_t filled = 0;
    for (std::size_t f = 0; f < frames; ++f) {
      const auto at = static_cast<std::size_t>(numbers_[f] - numbers_.front());
      evaluate_frame(values_.data() + f * values_per_frame_, angle_unit, motion.translations.data() + at * joints,
                     motion.rotations.data() + at * joints);
      for (; filled < at; ++filled)
        interpolate(motion, filled, f == 0 ? 0 : static_cast<std::size_t>(numbers_[f - 1] - numbers_.front()), at);
      filled = at + 1;
    }
  }

  [[nodiscard]] long missing_frames() const { return numbers_.back() - numbers_.front() + 1 - static_cast<long>(numbers_.size()); }

 private:
  bool stop(ErrorCode code, int line, std::string message, std::string remedy) {
    problems_.add(code, line, std::move(message), std::move(remedy));
    return false;
  }

  bool read_header(std::string_view word) {
    if (!frame_lines_.empty())
      return stop(ErrorCode::structure, scanner_.line(), in_quotes(word) + " is between frames.", "Move it before the first frame.");
    if (equal_ignoring_case(word, ":DEGREES")) degrees_ = true;
    if (equal_ignoring_case(word, ":RADIANS")) degrees_ = false;
    scanner_.rest_of_line();
    return true;
  }

  bool begin_frame() {
    if (!end_frame()) return false;
    const std::string_view word = scanner_.word();
    const int line = scanner_.line();
    const auto number = parse_long(word);
    if (!number || *number < 0 || *number > 2'000'000'000)
      return stop(ErrorCode::syntax, line, in_quotes(word) + " is not a frame number.",
                  "Begin each frame with its number, 0 or above, alone on a line.");
    if (const std::string_view rest = scanner_.rest_of_line(); !rest.empty() && !rest.starts_with('#'))
      return stop(ErrorCode::syntax, line, "The frame number is followed by " + in_quotes(rest) + ".",
                  "Write the frame number alone on a line; begin the line of a bone with its name.");
    if (!numbers_.empty()) {
      const long last = numbers_.back();
      if (*number <= last)
        return stop(ErrorCode::structure, line, "Frame " + std::to_string(*number) + " follows frame " + std::to_string(last) + ".",
                    "Sort the frames, each number once.");
      const double max_gap = std::max(1.0, rate_);  // number of frames in one second
      if (static_cast<double>(*number - last - 1) > max_gap)
        return stop(ErrorCode::structure, line,
                    "The frames between " + std::to_string(last) + " and " + std::to_string(*number) +
                        " are missing; at most one second is interpolated.",
                    "Split the motion there, or export it again.");
      missing_ += *number - last - 1;
      // Missing frames take memory but no text. Limit: 10 million interpolated bone poses, plus 8 for each byte of text.
      if (static_cast<std::uint64_t>(missing_) * asf_.bones.size() > 10'000'000 + 8 * text_size_)
        return stop(ErrorCode::range, line, "Too many frames are missing: " + std::to_string(missing_) + ".", "Export the motion again.");
    }
    numbers_.push_back(*number);
    frame_lines_.push_back(line);
    seen_.assign(asf_.bones.size(), 0);
    // Bones without DOFs take memory in every frame but no text. Limit: a million bone poses, plus 8 for each byte of text.
    if (std::uint64_t{numbers_.size()} * asf_.bones.size() > 1'000'000 + 8 * text_size_)
      return stop(ErrorCode::range, line, "Almost no bone has degrees of freedom.", "Remove bones that never move.");
    values_.resize(values_.size() + values_per_frame_, 0.0);
    return true;
  }

  bool end_frame() {
    if (frame_lines_.empty()) return true;
    for (std::size_t i = 0; i < seen_.size(); ++i) {
      if (seen_[i] || asf_.bones[i].dofs.empty()) continue;
      const bool last = !scanner_.skip_space();
      return stop(
          last ? ErrorCode::truncated : ErrorCode::structure, frame_lines_.back(),
          "Frame " + std::to_string(numbers_.back()) + " has no line for bone " + in_quotes(asf_.bones[i].name) + ".",
          last ? "The file was cut off; export or copy it again." : "Check that this motion belongs to this skeleton, or add the line.");
    }
    return true;
  }

  bool read_bone() {
    const std::string_view name = scanner_.word();
    const int line = scanner_.line();
    if (frame_lines_.empty())
      return stop(ErrorCode::syntax, line, in_quotes(name) + " precedes the first frame number.",
                  "Check that it is an AMC file; each frame begins with its number.");
    const auto found = index_.find(name);
    if (found == index_.end())
      return stop(ErrorCode::unknown, line, "The skeleton has no bone " + in_quotes(name) + ".",
                  "Read the motion with the ASF file that belongs to it.");
    const std::size_t bone = found->second;
    if (seen_[bone])
      return stop(ErrorCode::duplicate, line,
                  "Bone " + in_quotes(name) + " has two lines in frame " + std::to_string(numbers_.back()) + ".", "Remove one of them.");
    seen_[bone] = 1;
    const std::size_t count = asf_.bones[bone].dofs.size();
    double* values = values_.data() + values_.size() - values_per_frame_ + first_[bone];
    std::size_t n = 0;
    for (std::string_view word = scanner_.word_on_line(); !word.empty() && !word.starts_with('#'); word = scanner_.word_on_line(), ++n) {
      const auto value = measured_number(word);
      if (!value) {
        const NumberFault fault = number_fault(word);
        problems_.add(fault.code, line, fault.message, fault.remedy);
      }
      if (n < count) values[n] = value.value_or(0);
    }
    scanner_.rest_of_line();
    if (n != count)
      return stop(
          ErrorCode::structure, line,
          "Bone " + in_quotes(name) + " has " + std::to_string(n) + " values, but " + std::to_string(count) + " degrees of freedom.",
          "Check that this motion belongs to this skeleton, and that the line is complete.");
    return true;
  }

  /// Computes the pose of one frame from the values in the file.
  /// @param value       [values_per_frame_] file units
  /// @param angle_unit  rad per file unit of angle
  /// @param translation, rotation [joints, out] pose relative to the parent; translation in m
  void evaluate_frame(const double* value, double angle_unit, Vec3* translation, Quat* rotation) const {
    const std::size_t joints = asf_.skeleton.joints.size();
    const double unit = asf_.skeleton.unit;
    std::vector<double>& stretch = stretch_;
    stretch.assign(joints, 0.0);
    for (std::size_t i = 0; i < joints; ++i) {
      const SkeletonJoint& joint = asf_.skeleton.joints[i];
      const Asf::Bone& bone = asf_.bones[i];
      translation[i] = joint.offset;
      if (joint.parent >= 0) {
        const auto p = static_cast<std::size_t>(joint.parent);
        translation[i] += asf_.bones[p].direction * stretch[p];
      }
      Quat turn;
      Vec3 shift;
      for (const AsfDof& f : bone.dofs) {
        const double x = *value++;
        switch (f.kind) {
          case AsfDof::Kind::rotation: turn = axis_angle(axes_.unit(f.axis), x * angle_unit) * turn; break;
          case AsfDof::Kind::translation: shift += axes_.unit(f.axis) * (x * unit); break;
          case AsfDof::Kind::length: stretch[i] = x * unit; break;
        }
      }
      // The translation of the root is in world axes; the translation of a bone is in the bone's own frame.
      translation[i] += joint.parent < 0 ? shift : rotate(bone.axis, shift);
      rotation[i] = normalized(bone.axis * turn * bone.axis.conjugate());
    }
  }

  /// Interpolates frame `frame` between the frames `before` and `after`.
  static void interpolate(MeasuredMotion& motion, std::size_t frame, std::size_t before, std::size_t after) {
    const std::size_t joints = motion.skeleton.joints.size();
    const double s = static_cast<double>(frame - before) / static_cast<double>(after - before);
    for (std::size_t i = 0; i < joints; ++i) {
      const Vec3 a = motion.translations[before * joints + i], b = motion.translations[after * joints + i];
      motion.translations[frame * joints + i] = a + (b - a) * s;
      motion.rotations[frame * joints + i] = slerp(motion.rotations[before * joints + i], motion.rotations[after * joints + i], s);
    }
  }

  Scanner scanner_;
  std::uint64_t text_size_;
  const Asf& asf_;
  double rate_;
  Problems& problems_;
  FileAxes axes_;
  bool degrees_;
  std::map<std::string, std::size_t, std::less<>> index_;
  std::vector<std::size_t> first_;  ///< [bones] index of the bone's first value within a frame
  std::size_t values_per_frame_ = 0;
  std::vector<char> seen_;        ///< [bones] 1: the current frame has a line for the bone
  std::vector<long> numbers_;     ///< [frames] frame numbers of the file
  std::vector<int> frame_lines_;  ///< [frames] line in the file of each frame number
  std::vector<double> values_;    ///< [frames][values_per_frame_] file units
  long missing_ = 0;
  mutable std::vector<double> stretch_;  ///< [bones] m, lengthening of each bone in the frame that evaluate_frame computes
};

}  // namespace

Result<MeasuredMotion> read_amc(std::string_view text, std::string_view file_name, const Asf& asf, const AmcOptions& options,
                                ReadNotes* notes) {
  Problems problems(file_name);
  const auto plain = plain_text(text, "AMC", problems);
  if (!plain) return fail(problems.take());
  const double rate = options.rate > 0 && std::isfinite(options.rate) ? options.rate : 120;
  AmcReader reader(*plain, asf, rate, problems);
  if (!reader.read()) return fail(problems.take());
  MeasuredMotion motion;
  motion.name = stem_of(file_name);
  motion.source = std::string(file_name);
  motion.skeleton = asf.skeleton;
  reader.evaluate(motion);
  if (notes) {
    notes->frame_time = 0;
    notes->metres_per_unit = asf.skeleton.unit;
    notes->remarks.push_back("The AMC format does not specify the frame rate; " + to_text(rate) + " frames per second are assumed.");
    if (reader.missing_frames() > 0)
      notes->remarks.push_back(std::to_string(reader.missing_frames()) + " missing frames were filled by interpolation.");
  }
  return motion;
}

}  // namespace ugoki::formats
