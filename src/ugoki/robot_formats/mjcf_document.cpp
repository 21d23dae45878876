#include "ugoki/robot_formats/mjcf_document.h"

#include <algorithm>

namespace ugoki::robot_formats {
namespace {

constexpr std::size_t max_files = 200;  // maximum number of included and attached files of a model; bounds the recursion over includes

/// Name of the set of defaults for this kind of element. All actuators share one set; so do both kinds of tendon, and all equalities.
std::string_view family_of(std::string_view kind) {
  for (const std::string_view k : {"motor", "position", "velocity", "intvelocity", "damper", "cylinder", "muscle", "adhesion", "dcmotor"})
    if (kind == k) return "general";
  for (const std::string_view k : {"spatial", "fixed"})
    if (kind == k) return "tendon";
  for (const std::string_view k : {"connect", "weld", "distance", "flex"})
    if (kind == k) return "equality";
  return kind;
}

}  // namespace

XmlFields* MjcfFiles::parse(std::string_view text, const std::string& file_name) {
  files_.push_back(std::make_unique<XmlFields>(file_name, "MJCF"));
  XmlFields* const file = files_.back().get();
  text_ += text.size();
  if (files_.size() > max_files || text_ > max_text) {
    file->problem(1, ErrorCode::range, "The model has more than " + std::to_string(max_files) + " files or more than 256 MB of text.",
                  "Use fewer or smaller files.");
    return nullptr;
  }
  return file->parse(text) ? file : nullptr;
}

Result<std::string> MjcfFiles::read(const std::string& path) const {
  if (!read_) return fail(ErrorCode::io, path, "Files next to the description cannot be read here.", "Read the description from a folder.");
  return read_(path);
}

bool MjcfFiles::failed() const {
  return std::ranges::any_of(files_, [](const auto& f) { return f->failed(); });
}
bool MjcfFiles::full() const {
  return std::ranges::any_of(files_, [](const auto& f) { return f->full(); });
}

Error MjcfFiles::take_problems() {
  Error out;
  for (const auto& file : files_)
    for (Problem& p : file->take_problems().problems) {
      const bool known = std::ranges::any_of(
          out.problems, [&](const Problem& o) { return o.location == p.location && o.message == p.message && o.code == p.code; });
      if (!known && out.problems.size() < 20) out.problems.push_back(std::move(p));
    }
  return out;
}

std::vector<std::string> MjcfFiles::take_notes() {
  std::vector<std::string> out;
  for (const auto& file : files_)
    for (std::string& note : file->take_notes()) out.push_back(std::move(note));
  return out;
}

bool MjcfDocument::load(std::string_view text, const std::string& file_name, const std::string& folder, MjcfFiles& files) {
  XmlFields* const file = files.parse(text, file_name);
  if (!file) return false;
  root_ = {file->root(), file};
  paths_.push_back(file_name);
  if (root_.kind() != "mujoco") {
    root_.problem(ErrorCode::syntax, "The outermost element is " + root_.title() + ", not <mujoco>.",
                  "Give an MJCF file, whose outermost element is <mujoco>.");
    return false;
  }
  return load_includes(root_, folder, files);
}

bool MjcfDocument::load_includes(const MjcfElement& from, const std::string& folder, MjcfFiles& files) {
  // A loop over the levels of one file, no recursion. The recursion over included files is bounded by max_files.
  std::vector<pugi::xml_node> open = {from.node};
  bool complete = true;
  while (!open.empty()) {
    const pugi::xml_node node = open.back();
    open.pop_back();
    std::vector<pugi::xml_node> below;
    for (const pugi::xml_node child : node.children()) {
      if (child.type() != pugi::node_element) continue;
      if (std::string_view(child.name()) != "include") {
        below.push_back(child);
        continue;
      }
      const MjcfElement include{child, from.file};
      const std::string path = folder + from.file->required_text(include.attribute("file"));
      if (path == folder) {
        complete = false;
        continue;
      }
      if (std::ranges::find(paths_, path) != paths_.end()) {
        include.problem(ErrorCode::duplicate, formats::path_in_quotes(path) + " is included more than once, or includes itself.",
                        "Include each file only once.");
        complete = false;
        continue;
      }
      const Result<std::string> text = files.read(path);
      if (!text) {
        include.problem(ErrorCode::io,
                        "The included file " + formats::path_in_quotes(path) + " cannot be read: " + text.error().problems[0].message,
                        "Copy it to the folder of the model.");
        complete = false;
        continue;
      }
      paths_.push_back(path);
      XmlFields* const file = files.parse(*text, path);
      if (!file) return false;
      const MjcfElement root{file->root(), file};
      included_.emplace(child.internal_object(), root);
      complete = load_includes(root, folder, files) && complete;
    }
    open.insert(open.end(), below.rbegin(), below.rend());
  }
  return complete;
}

void MjcfDocument::append_children(const MjcfElement& parent, std::vector<MjcfElement>& out) const {
  for (const pugi::xml_node child : parent.node.children()) {
    if (child.type() != pugi::node_element) continue;
    if (const auto it = included_.find(child.internal_object()); it != included_.end())
      append_children(it->second, out);
    else
      out.push_back({child, parent.file});
  }
}

std::vector<MjcfElement> MjcfDocument::children(const MjcfElement& parent) const {
  std::vector<MjcfElement> out;
  append_children(parent, out);
  return out;
}

std::vector<MjcfElement> MjcfDocument::sections(std::string_view kind) const {
  std::vector<MjcfElement> out = children(root_);
  std::erase_if(out, [&](const MjcfElement& e) { return e.kind() != kind; });
  return out;
}

const MjcfElement* MjcfAttributes::level_of(const char* name) const {
  const auto it = std::ranges::find_if(levels_, [&](const MjcfElement& e) { return e.has(name); });
  return it == levels_.end() ? nullptr : &*it;
}

std::string MjcfAttributes::text(const char* name) const {
  const MjcfElement* const e = level_of(name);
  return e ? e->text(name) : std::string();
}
double MjcfAttributes::number(const char* name, double fallback, Bounds bounds) const {
  const MjcfElement* const e = level_of(name);
  return e ? e->file->number(e->attribute(name), fallback, bounds) : fallback;
}
int MjcfAttributes::integer(const char* name, int fallback, int low, int high) const {
  const MjcfElement* const e = level_of(name);
  return e ? e->file->integer(e->attribute(name), fallback, low, high) : fallback;
}
bool MjcfAttributes::flag(const char* name, bool fallback) const {
  const MjcfElement* const e = level_of(name);
  return e ? e->file->flag(e->attribute(name), fallback) : fallback;
}
Vec3 MjcfAttributes::vec3(const char* name, const Vec3& fallback) const {
  const MjcfElement* const e = level_of(name);
  return e ? e->file->vec3(e->attribute(name), fallback) : fallback;
}
bool MjcfAttributes::numbers(const char* name, std::span<double> out, Bounds bounds) const {
  const MjcfElement* const e = level_of(name);
  return e && e->file->numbers(e->attribute(name), out, bounds);
}

int MjcfAttributes::keyword(const char* name, std::initializer_list<std::string_view> words, int fallback) const {
  const MjcfElement* const e = level_of(name);
  if (!e) return fallback;
  const XmlField field = e->attribute(name);
  const auto* const it = std::find(words.begin(), words.end(), field.text);
  if (it != words.end()) return static_cast<int>(it - words.begin());
  std::string all;
  for (const std::string_view w : words) all += (all.empty() ? "" : ", ") + std::string(w);
  e->file->problem(field, ErrorCode::unknown, ": " + formats::in_quotes(field.text) + " is not an allowed value.",
                   "Write one of: " + all + ".");
  return fallback;
}

bool MjcfAttributes::range(const char* name, std::span<double, 2> out) const {
  const MjcfElement* const e = level_of(name);
  if (!e) return false;
  const XmlField field = e->attribute(name);
  const std::size_t gap = field.text.find_first_of(" \t\r\n");
  XmlField first = field, second = field;
  first.text = field.text.substr(0, gap);
  second.text = gap == std::string_view::npos ? std::string_view() : field.text.substr(field.text.find_first_not_of(" \t\r\n", gap));
  if (first.text.empty() || second.text.empty() || second.text.find_first_of(" \t\r\n") != std::string_view::npos) {
    e->file->problem(field, ErrorCode::syntax, " does not have exactly two numbers.", "Give a lower and an upper bound.");
    return false;
  }
  out[0] = e->file->limit(first, out[0]);
  out[1] = e->file->limit(second, out[1]);
  return true;
}

std::size_t MjcfAttributes::overlay(const char* name, std::span<double> out, Bounds bounds) const {
  std::size_t count = 0;
  for (auto level = levels_.rbegin(); level != levels_.rend(); ++level) {
    if (!level->has(name)) continue;
    const std::vector<double> values = level->file->list(level->attribute(name), 1, out.size(), bounds);
    std::copy(values.begin(), values.end(), out.begin());
    count = std::max(count, values.size());
  }
  return count;
}

void MjcfDefaults::read(const MjcfDocument& document) {
  classes_["main"];
  for (const MjcfElement& section : document.sections("default")) read_class(document, section, {}, 0);
}

void MjcfDefaults::read_class(const MjcfDocument& document, const MjcfElement& element, const std::string& parent, int depth) {
  std::string name = element.text("class");
  if (depth == 0) {
    // The outermost class may have its own name. It is stored as a class without settings whose parent is "main": both names mean the same.
    const bool named = !name.empty() && name != "main";
    if (named && outermost_names_.insert(name).second && !classes_.emplace(name, Class{"main", {}}).second)
      return element.problem(ErrorCode::duplicate, "Two default classes are named " + formats::in_quotes(name) + ".",
                             "Rename one of them.");
    name = "main";
  } else if (name.empty()) {
    return element.problem(ErrorCode::syntax, "A nested default class has no name.", "Add class=\"...\".");
  } else if (!classes_.emplace(name, Class{parent, {}}).second) {
    return element.problem(ErrorCode::duplicate, "Two default classes are named " + formats::in_quotes(name) + ".", "Rename one of them.");
  }
  if (depth > static_cast<int>(formats::max_depth))
    return element.problem(ErrorCode::range, "Default classes are nested deeper than 1000 levels.", "Nest at most 1000 levels.");
  for (const MjcfElement& child : document.children(element)) {
    if (child.kind() == "default")
      read_class(document, child, name, depth + 1);
    else
      classes_.find(name)->second.elements[std::string(family_of(child.kind()))].push_back(child);
  }
}

MjcfAttributes MjcfDefaults::attributes(const MjcfElement& element, const std::string& childclass, std::string_view family) const {
  MjcfAttributes out(element);
  std::string name = element.has("class") ? element.text("class") : childclass;
  if (name.empty()) name = "main";
  if (!knows(name)) {
    element.problem(ErrorCode::unknown, "No default class is named " + formats::in_quotes(name) + ".",
                    "Correct the name, or add the class.");
    name = "main";
  }
  if (family.empty()) family = family_of(element.kind());
  while (!name.empty()) {
    const Class& c = classes_.find(name)->second;
    if (const auto it = c.elements.find(family); it != c.elements.end())
      for (auto e = it->second.rbegin(); e != it->second.rend(); ++e) out.add_level(*e);
    name = c.parent;
  }
  return out;
}

}  // namespace ugoki::robot_formats
