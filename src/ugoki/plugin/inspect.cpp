#include "ugoki/plugin/inspect.h"

#include <elf.h>

#include <algorithm>
#include <cstring>

#include "ugoki/base/sha256.h"
#include "ugoki/files/files.h"
#include "ugoki/fmi/archive.h"

namespace ugoki::plugin {
namespace {

constexpr std::size_t max_bytes = std::size_t{1} << 30;  // maximum size of a library's file, as in load_library
constexpr std::size_t max_names = 10'000;                // maximum number of LSIs of one library, as in read_declarations
constexpr std::size_t max_name = 100;                    // maximum number of bytes of a name; longer names are cut
constexpr std::size_t max_variables = 20;                // maximum number of writable variables that the warning lists

#if defined(__x86_64__)
constexpr Elf64_Half own_machine = EM_X86_64;
#elif defined(__aarch64__)
constexpr Elf64_Half own_machine = EM_AARCH64;
#else
constexpr Elf64_Half own_machine = EM_NONE;  // other processors: the field is not checked
#endif

/// Copies a text of an untrusted file for a terminal: control characters (also the two-byte ones of UTF-8) become '?'.
std::string plain(std::string_view text) {
  std::string out(text.substr(0, max_name));
  for (std::size_t i = 0; i < out.size(); ++i) {
    const auto c = static_cast<unsigned char>(out[i]);
    const auto next = static_cast<unsigned char>(i + 1 < out.size() ? out[i + 1] : 0);
    if (c < 0x20 || c == 0x7f || (c == 0xc2 && next >= 0x80 && next < 0xa0)) out[i] = '?';
    if (c >= 0x80 && c < 0xa0 && i > 0 && out[i - 1] == '?') out[i] = '?';
  }
  return out;
}

/// An ELF file in memory. Each access is checked against the end of the file.
class Elf {
 public:
  explicit Elf(std::string_view bytes) : bytes_(bytes) {}

  /// Reads the header and the table of sections. @return the reason why it cannot be read; empty: success
  std::string open() {
    Elf64_Ehdr header;
    if (!read(0, header)) return "it is shorter than an ELF header";
    if (std::memcmp(header.e_ident, ELFMAG, SELFMAG) != 0) return "it does not begin like an ELF file";
    if (header.e_ident[EI_CLASS] != ELFCLASS64 || header.e_ident[EI_DATA] != ELFDATA2LSB ||
        (own_machine != EM_NONE && header.e_machine != own_machine))
      return "it was built for another kind of machine";
    if (header.e_type != ET_DYN) return "it is an ELF file, but not a shared library";
    if (header.e_shnum == 0) return "it has no table of sections";
    if (header.e_shentsize != sizeof(Elf64_Shdr)) return "the entries of its table of sections have another size than ELF requires";
    sections_.resize(header.e_shnum);
    for (std::size_t i = 0; i < sections_.size(); ++i) {
      if (header.e_shoff > bytes_.size() || !read(header.e_shoff + i * sizeof(Elf64_Shdr), sections_[i]))
        return "its table of sections reaches beyond the end of the file";
      const Elf64_Shdr& s = sections_[i];
      if (s.sh_type != SHT_NOBITS && (s.sh_offset > bytes_.size() || s.sh_size > bytes_.size() - s.sh_offset))
        return "its section " + std::to_string(i) + " reaches beyond the end of the file";
    }
    if (header.e_shstrndx >= sections_.size()) return "it has no names of sections";
    names_ = header.e_shstrndx;
    return {};
  }

  /// Calls visit(tag, text) for the entries DT_NEEDED, DT_RPATH and DT_RUNPATH. They are found as the dynamic linker finds them, by the
  /// segments, because the table of sections need not agree with the segments.
  template <class Visit>
  void each_dynamic_text(Visit visit) const {
    Elf64_Ehdr header;
    if (!read(0, header)) return;
    std::vector<Elf64_Phdr> segments(header.e_phentsize == sizeof(Elf64_Phdr) ? header.e_phnum : 0);
    for (std::size_t i = 0; i < segments.size(); ++i)
      if (!read(header.e_phoff + i * sizeof(Elf64_Phdr), segments[i])) return;
    const auto offset_of = [&](Elf64_Addr address) {
      for (const Elf64_Phdr& s : segments)
        if (s.p_type == PT_LOAD && address >= s.p_vaddr && address - s.p_vaddr < s.p_filesz)
          return static_cast<std::size_t>(s.p_offset + (address - s.p_vaddr));
      return bytes_.size();
    };
    for (const Elf64_Phdr& s : segments) {
      if (s.p_type != PT_DYNAMIC) continue;
      std::vector<Elf64_Dyn> entries;
      std::size_t texts = bytes_.size();
      for (std::size_t at = offset_of(s.p_vaddr);; at += sizeof(Elf64_Dyn)) {
        Elf64_Dyn entry;
        if (!read(at, entry) || entry.d_tag == DT_NULL) break;
        if (entry.d_tag == DT_STRTAB) texts = offset_of(entry.d_un.d_ptr);
        entries.push_back(entry);
      }
      for (const Elf64_Dyn& e : entries) {
        if (e.d_tag != DT_NEEDED && e.d_tag != DT_RPATH && e.d_tag != DT_RUNPATH) continue;
        const std::size_t at = texts + e.d_un.d_val;
        if (texts >= bytes_.size() || e.d_un.d_val >= bytes_.size() - texts) continue;
        visit(e.d_tag, bytes_.substr(at, bytes_.find('\0', at) - at));
      }
    }
  }

  [[nodiscard]] const std::vector<Elf64_Shdr>& sections() const { return sections_; }
  [[nodiscard]] std::string_view name_of(const Elf64_Shdr& s) const { return text(names_, s.sh_name); }
  [[nodiscard]] std::string_view content_of(const Elf64_Shdr& s) const {
    return s.sh_type == SHT_NOBITS ? std::string_view() : bytes_.substr(s.sh_offset, s.sh_size);
  }
  /// A zero-terminated text in a table of texts; empty if there is none.
  [[nodiscard]] std::string_view text(std::size_t table, std::size_t at) const {
    if (table >= sections_.size()) return {};
    const std::string_view all = content_of(sections_[table]);
    return at < all.size() ? all.substr(at, all.find('\0', at) - at) : std::string_view();
  }
  /// Calls visit(symbol, name) for the symbols of all tables of the type SHT_DYNSYM or SHT_SYMTAB.
  template <class Visit>
  void each_symbol(Elf64_Word type, Visit visit) const {
    for (const Elf64_Shdr& s : sections_) {
      if (s.sh_type != type) continue;
      for (std::size_t at = 0; at + sizeof(Elf64_Sym) <= s.sh_size; at += sizeof(Elf64_Sym)) {
        Elf64_Sym symbol;
        if (read(s.sh_offset + at, symbol)) visit(symbol, text(s.sh_link, symbol.st_name));
      }
    }
  }

 private:
  template <class T>
  [[nodiscard]] bool read(std::size_t at, T& to) const {
    if (at > bytes_.size() || sizeof(T) > bytes_.size() - at) return false;
    std::memcpy(&to, bytes_.data() + at, sizeof(T));
    return true;
  }

  std::string_view bytes_;
  std::vector<Elf64_Shdr> sections_;
  std::size_t names_ = 0;
};

/// Reads the section that the LSI builder writes: zero-terminated texts "library NAME" and "lsi NAME".
void read_manifest(std::string_view content, Inspection& out) {
  while (!content.empty()) {
    const std::size_t end = std::min(content.find('\0'), content.size());
    const std::string_view line = content.substr(0, end);
    content.remove_prefix(std::min(end + 1, content.size()));
    if (line.starts_with("library ") && out.name.empty()) out.name = plain(line.substr(8));
    if (line.starts_with("lsi ") && out.lsis.size() < max_names) out.lsis.push_back(plain(line.substr(4)));
  }
}

/// True for the libraries of C and C++ and of the sanitizers, which every program may load.
bool is_standard(std::string_view library) {
  for (const char* stem : {"libc.so", "libm.so", "libstdc++.so", "libgcc_s.so", "libpthread.so", "libdl.so", "librt.so",
                           "ld-linux-x86-64.so", "libatomic.so", "libgomp.so", "libasan.so", "libubsan.so", "libtsan.so"})
    if (library.starts_with(stem)) return true;
  return false;
}

/// True for variables of the compiler, the C and C++ libraries and the LSI headers.
bool is_foreign(std::string_view name) {
  if (name.empty() || name.starts_with("__") || name.starts_with("DW.ref.") || name.starts_with("completed.") ||
      name.starts_with("_DYNAMIC") || name.starts_with("_GLOBAL_OFFSET_TABLE_"))
    return true;
  for (const char* start : {"_ZSt", "_ZNSt", "_ZNKSt", "_ZZNSt", "_ZGV", "_ZTV", "_ZTI", "_ZTS", "_ZN9__gnu_cxx"})
    if (name.starts_with(start)) return true;
  return name.find("ugoki_lsi_") != std::string_view::npos || name.find("ugoki_gen_") != std::string_view::npos ||
         name.find("5ugoki10lsi_detail") != std::string_view::npos;
}

/// The name of a variable as in the source: local static variables are "count.0" in C and "_ZZ1fdE5count" in C++.
std::string source_name(std::string_view name) {
  if (!name.starts_with("_Z")) return plain(name.substr(0, name.find('.')));
  std::string_view last = name;  // the last "LENGTH NAME" of the mangled name
  for (std::size_t at = 2; at < name.size();) {
    std::size_t length = 0;
    while (at < name.size() && name[at] >= '0' && name[at] <= '9' && length <= name.size())
      length = length * 10 + static_cast<std::size_t>(name[at++] - '0');
    if (length > 0 && length <= name.size() - at) {
      last = name.substr(at, length);
      at += length;
    } else {
      ++at;
    }
  }
  return plain(last);
}

}  // namespace

Result<Inspection> inspect_elf(std::string_view bytes, const std::string& location) {
  Elf elf(bytes);
  if (const std::string why = elf.open(); !why.empty())
    return fail(ErrorCode::syntax, location, "The file cannot be opened as a library of LSIs: " + why + ".",
                "Build it on this machine: ugoki lsi build FILE.c");
  Inspection out;
  bool exports = false;
  elf.each_symbol(SHT_DYNSYM, [&](const Elf64_Sym& s, std::string_view name) {
    exports = exports || (name == "ugoki_lsi_library" && s.st_shndx != SHN_UNDEF);
  });
  if (!exports)
    return fail(ErrorCode::syntax, location, "The file is not a library of LSIs: it does not export ugoki_lsi_library.",
                "Build it with: ugoki lsi build FILE.c");
  elf.each_dynamic_text([&](Elf64_Sxword tag, std::string_view text) {
    if (tag == DT_NEEDED && !is_standard(text) && out.needed.size() < max_names) out.needed.push_back(plain(text));
    if (tag != DT_NEEDED) out.search_path += (out.search_path.empty() ? "" : ":") + plain(text);
  });
  for (const Elf64_Shdr& s : elf.sections())
    if (elf.name_of(s) == ".ugoki.lsi") read_manifest(elf.content_of(s), out);
  elf.each_symbol(SHT_SYMTAB, [&](const Elf64_Sym& s, std::string_view name) {
    const unsigned type = ELF64_ST_TYPE(s.st_info);
    if ((type != STT_OBJECT && type != STT_TLS) || s.st_shndx >= elf.sections().size() || s.st_size == 0) return;
    const Elf64_Shdr& home = elf.sections()[s.st_shndx];
    const std::string_view section = elf.name_of(home);
    const bool data = section.starts_with(".data") || section.starts_with(".bss") || section.starts_with(".tdata") ||
                      section.starts_with(".tbss") || section.starts_with(".ldata") || section.starts_with(".lbss");
    if ((home.sh_flags & SHF_WRITE) == 0 || !data || section.starts_with(".data.rel.ro") || is_foreign(name)) return;
    if (out.writable.size() < max_variables) out.writable.push_back(source_name(name));
  });
  std::sort(out.writable.begin(), out.writable.end());
  out.writable.erase(std::unique(out.writable.begin(), out.writable.end()), out.writable.end());
  return out;
}

Result<Inspection> inspect_library(const std::string& path) {
  const Result<std::string> bytes = files::read_regular_file(path, max_bytes);
  if (!bytes) return fail(bytes.error());
  Inspection out;
  if (fmi::is_zip(*bytes)) {
    out.fmu = true;
  } else {
    Result<Inspection> elf = inspect_elf(*bytes, path);
    if (!elf) return fail(std::move(elf.error()));
    out = std::move(*elf);
  }
  out.hash = sha256(*bytes);
  return out;
}

std::vector<std::string> writable_warnings(const Inspection& inspection, const std::string& location) {
  std::vector<std::string> out;
  for (const std::string& name : inspection.writable)
    out.push_back(
        location + ": the variable '" + name +
        "' is global or static and keeps its value when a circuit restarts, so a second run may give other results. Move it to the "
        "state of the LSI.");
  return out;
}

}  // namespace ugoki::plugin
