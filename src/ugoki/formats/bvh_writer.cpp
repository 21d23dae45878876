#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>

#include "ugoki/base/number.h"
#include "ugoki/formats/bvh.h"
#include "ugoki/formats/file_axes.h"

namespace ugoki::formats {
namespace {

/// Order of rotations about three different axes of the file (0 x, 1 y, 2 z); the first one is the outermost.
struct Order {
  int axis[3];
};

/// Parses `letters` ("ZXY"); missing axes are added. Returns ZXY if `letters` repeats an axis or has more than three letters.
Order order_of(const std::string& letters) {
  Order order{{2, 0, 1}};
  bool used[3] = {false, false, false};
  int found[3] = {};
  int n = 0;
  for (const char c : letters) {
    const int a = c == 'X' ? 0 : c == 'Y' ? 1 : c == 'Z' ? 2 : -1;
    if (a < 0 || used[a] || n == 3) return order;
    used[a] = true;
    found[n++] = a;
  }
  for (const int a : {2, 0, 1})  // missing axes are appended as the innermost rotations
    if (!used[a]) found[n++] = a;
  return {{found[0], found[1], found[2]}};
}

double rounded(double value, double scale) { return std::round(value * scale) / scale; }

class Writer {
 public:
  Writer(const MeasuredMotion& motion, const BvhWriteOptions& options)
      : motion_(motion), joints_(motion.skeleton.joints), axes_{options.z_up}, decimals_(std::clamp(options.decimals, 1, 15)) {
    const double unit = options.metres_per_unit > 0 ? options.metres_per_unit : motion.skeleton.unit;
    per_metre_ = unit > 0 && std::isfinite(unit) ? 1 / unit : 1;
    for (int i = 0; i < decimals_; ++i) scale_ *= 10;
    children_.resize(joints_.size());
    for (std::size_t i = 0; i < joints_.size(); ++i)
      if (joints_[i].parent >= 0) children_[static_cast<std::size_t>(joints_[i].parent)].push_back(i);
    for (const SkeletonJoint& j : joints_) orders_.push_back(order_of(j.rotation_order));
    previous_.resize(joints_.size());
  }

  std::string write() {
    sequence_.reserve(joints_.size());
    out_.reserve(joints_.size() * 200 + static_cast<std::size_t>(motion_.frames) * joints_.size() * 40);
    write_hierarchy();
    out_ += "MOTION\nFrames: " + std::to_string(motion_.frames) + "\nFrame Time: " + to_text(1 / motion_.rate) + "\n";
    for (int f = 0; f < motion_.frames; ++f) write_frame(static_cast<std::size_t>(f));
    return std::move(out_);
  }

 private:
  bool has_position(std::size_t i) const { return joints_[i].parent < 0 || joints_[i].translates; }

  void indent(std::size_t depth) { out_.append(depth, '\t'); }

  void add_number(double value) {
    char buffer[400];
    if (!std::isfinite(value)) value = 0;
    // The value is written as an integer count of units in its last decimal digit, which is faster than std::to_chars of the double. The
    // count is exact below 2^53 = 9.007e15.
    if (const double steps = std::round(value * scale_); std::fabs(steps) < 9e15) {
      const auto all = static_cast<std::uint64_t>(std::fabs(steps)), unit = static_cast<std::uint64_t>(scale_);
      if (steps < 0) out_ += '-';
      char* end = std::to_chars(buffer, buffer + sizeof buffer, all / unit).ptr;
      if (std::uint64_t rest = all % unit; rest > 0) {
        *end = '.';
        for (int i = decimals_; i > 0; --i, rest /= 10) end[i] = static_cast<char>('0' + rest % 10);
        end += decimals_ + 1;
        while (end[-1] == '0') --end;
      }
      out_.append(buffer, end);
      return;
    }
    auto [end, error] = std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::fixed, decimals_);
    while (end[-1] == '0') --end;
    if (end[-1] == '.') --end;
    const std::string_view digits(buffer, static_cast<std::size_t>(end - buffer));
    out_ += digits == "-0" ? std::string_view("0") : digits;
  }

  void add_vector(const Vec3& metres) {
    const Vec3 v = axes_.to_file(metres) * per_metre_;
    for (int i = 0; i < 3; ++i) {
      out_ += ' ';
      add_number(v[i]);
    }
  }

  std::string clean_name(std::size_t i) const {
    std::string name;
    for (const char c : joints_[i].name) name += c == '{' || c == '}' || c == '\n' || c == '\r' || c == '\t' ? '_' : c;
    while (!name.empty() && name.back() == ' ') name.pop_back();
    return name.empty() ? "joint" + std::to_string(i + 1) : name;
  }

  /// Writes the joints depth first, without recursion. Stores their order in sequence_; the values of each frame have this order.
  void write_hierarchy() {
    struct Visit {
      std::size_t joint, next_child;
    };
    std::vector<Visit> stack;
    out_ += "HIERARCHY\n";
    for (std::size_t root = 0; root < joints_.size(); ++root) {
      if (joints_[root].parent >= 0) continue;
      open(root, 0);
      stack.push_back({root, 0});
      while (!stack.empty()) {
        Visit& top = stack.back();
        if (top.next_child < children_[top.joint].size()) {
          const std::size_t child = children_[top.joint][top.next_child++];
          open(child, stack.size());
          stack.push_back({child, 0});
        } else {
          stack.pop_back();
          indent(stack.size());
          out_ += "}\n";
        }
      }
    }
  }

  void open(std::size_t i, std::size_t depth) {
    sequence_.push_back(i);
    indent(depth);
    out_ += (depth == 0 ? "ROOT " : "JOINT ") + clean_name(i) + "\n";
    indent(depth);
    out_ += "{\n";
    indent(depth + 1);
    out_ += "OFFSET";
    add_vector(joints_[i].offset);
    out_ += '\n';
    indent(depth + 1);
    out_ += has_position(i) ? "CHANNELS 6 Xposition Yposition Zposition" : "CHANNELS 3";
    for (const int a : orders_[i].axis) {
      out_ += ' ';
      out_ += "XYZ"[a];
      out_ += "rotation";
    }
    out_ += '\n';
    for (const Vec3& e : joints_[i].end_sites) {
      indent(depth + 1);
      out_ += "End Site\n";
      indent(depth + 1);
      out_ += "{\n";
      indent(depth + 2);
      out_ += "OFFSET";
      add_vector(e);
      out_ += '\n';
      indent(depth + 1);
      out_ += "}\n";
    }
  }

  void write_frame(std::size_t frame) {
    bool first = true;
    for (const std::size_t i : sequence_) {
      const std::size_t at = frame * joints_.size() + i;
      if (has_position(i)) {
        const Vec3 p = axes_.to_file(motion_.translations[at]) * per_metre_;
        for (int k = 0; k < 3; ++k) {
          if (!first) out_ += ' ';
          first = false;
          add_number(p[k]);
        }
      }
      const Vec3 angles = angles_near(to_matrix(motion_.rotations[at]), orders_[i], frame == 0 ? Vec3{} : previous_[i]);
      previous_[i] = angles;
      for (int k = 0; k < 3; ++k) {
        if (!first) out_ += ' ';
        first = false;
        add_number(angles[k]);
      }
    }
    out_ += '\n';
  }

  /// Returns angles a0, a1, a2 [deg] with R = R0(a0) R1(a1) R2(a2), where Rn rotates about axis n of `order`. Of the two solutions, returns
  /// the one closest to `previous` [deg], rounded as it is written. a1 and a2 are computed from R after removal of the rounded outer
  /// rotation R0. This compensates the rounding error of a0, also at the gimbal pole.
  Vec3 angles_near(const Mat3& R, const Order& order, const Vec3& previous) const {
    const int i = axes_.ours(order.axis[0]), j = axes_.ours(order.axis[1]), k = axes_.ours(order.axis[2]);
    const double sign = (j - i + 3) % 3 == 1 ? 1.0 : -1.0;
    const double jk = R.row(j)[k], kk = R.row(k)[k];
    // At the gimbal pole the outer and the inner axis coincide, to within the rounding of the text. The outer angle then keeps its previous
    // value. `pole` is the sine of a quarter of a unit in the last written digit.
    const double pole = 0.25 * (pi / 180) / scale_;
    const double a0 = jk * jk + kk * kk > pole * pole ? atan2(-sign * jk, kk) * (180 / pi) : previous.x;
    const Vec3 one = solve(R, i, j, k, sign, a0, previous);
    if (distance(one, previous) <= 90) return one;  // the other solution differs by 180 degrees in a0: it is at least 90 degrees away
    const Vec3 two = solve(R, i, j, k, sign, a0 + 180, previous);
    return distance(one, previous) <= distance(two, previous) ? one : two;
  }

  /// Returns the three angles [deg], rounded as they are written, for the outer angle a0 [deg]. i, j, k, sign: see angles_near.
  Vec3 solve(const Mat3& R, int i, int j, int k, double sign, double a0, const Vec3& previous) const {
    const double first = rounded(near(a0, previous.x), scale_);
    Vec3 axis;
    axis[i] = 1;
    const Mat3 M = rotation_about(axis, -first * (pi / 180)) * R;  // M = R1(a1) R2(a2)
    const double a1 = atan2(sign * M.row(i)[k], M.row(k)[k]) * (180 / pi);
    const double a2 = atan2(sign * M.row(j)[i], M.row(j)[j]) * (180 / pi);
    return {first, rounded(near(a1, previous.y), scale_), rounded(near(a2, previous.z), scale_)};
  }

  /// Adds the multiple of 360 to `angle` [deg] that makes the sum closest to `target` [deg].
  static double near(double angle, double target) { return angle + 360 * std::round((target - angle) / 360); }
  static double distance(const Vec3& a, const Vec3& b) { return std::fabs(a.x - b.x) + std::fabs(a.y - b.y) + std::fabs(a.z - b.z); }

  const MeasuredMotion& motion_;
  const std::vector<SkeletonJoint>& joints_;
  FileAxes axes_;
  int decimals_;
  double per_metre_ = 1, scale_ = 1;
  std::vector<std::vector<std::size_t>> children_;
  std::vector<std::size_t> sequence_;  ///< joints in the order in which they are written
  std::vector<Order> orders_;
  std::vector<Vec3> previous_;  ///< [joints] deg, angles of the previous frame
  std::string out_;
};

}  // namespace

std::string write_bvh(const MeasuredMotion& motion, const BvhWriteOptions& options) { return Writer(motion, options).write(); }

}  // namespace ugoki::formats
