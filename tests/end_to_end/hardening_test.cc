// Checks the compiler's and the linker's hardening in the built program. A flag that the build
// files lose breaks no other test.

#include <elf.h>
#include <gtest/gtest.h>

#include <cstring>
#include <set>
#include <string>
#include <vector>

#include "tests/support/program.h"
#include "tests/support/read_file.h"

namespace hpdm {
namespace {

/// The parts of a program that the loader reads, for this machine's word length (ELF64).
class Program {
 public:
  explicit Program(const std::string& path) : bytes_(ReadFile(path)), header_(At<Elf64_Ehdr>(0)) {
    for (int i = 0; i < header_.e_phnum; ++i) {
      segments_.push_back(At<Elf64_Phdr>(header_.e_phoff + i * sizeof(Elf64_Phdr)));
    }
    for (const Elf64_Phdr& segment : segments_) {
      if (segment.p_type != PT_DYNAMIC) continue;
      for (std::size_t at = 0; at < segment.p_filesz; at += sizeof(Elf64_Dyn)) {
        dynamic_.push_back(At<Elf64_Dyn>(segment.p_offset + at));
      }
    }
    for (int i = 0; i < header_.e_shnum; ++i) ReadSymbols(Section(i));
  }

  bool IsElf64() const {
    return bytes_.starts_with(ELFMAG) && header_.e_ident[EI_CLASS] == ELFCLASS64;
  }
  int type() const { return header_.e_type; }
  const std::vector<Elf64_Phdr>& segments() const { return segments_; }
  /// Functions that the program takes from libraries, among others.
  const std::set<std::string>& symbols() const { return symbols_; }

  /// All flags of an entry of the dynamic section.
  std::uint64_t Flags(std::int64_t tag) const {
    std::uint64_t flags = 0;
    for (const Elf64_Dyn& entry : dynamic_) {
      if (entry.d_tag == tag) flags |= entry.d_un.d_val;
    }
    return flags;
  }
  const Elf64_Phdr* Segment(std::uint32_t type) const {
    for (const Elf64_Phdr& segment : segments_) {
      if (segment.p_type == type) return &segment;
    }
    return nullptr;
  }

 private:
  template <typename T>
  T At(std::uint64_t offset) const {
    T value{};
    if (offset + sizeof(T) <= bytes_.size()) {
      std::memcpy(&value, bytes_.data() + offset, sizeof(T));
    }
    return value;
  }
  Elf64_Shdr Section(std::uint32_t index) const {
    return At<Elf64_Shdr>(header_.e_shoff + index * sizeof(Elf64_Shdr));
  }
  void ReadSymbols(const Elf64_Shdr& section) {
    if (section.sh_type != SHT_DYNSYM) return;
    const std::uint64_t names = Section(section.sh_link).sh_offset;
    for (std::size_t at = 0; at < section.sh_size; at += sizeof(Elf64_Sym)) {
      const std::uint64_t name = names + At<Elf64_Sym>(section.sh_offset + at).st_name;
      if (name < bytes_.size()) symbols_.insert(bytes_.data() + name);
    }
  }

  std::string bytes_;
  Elf64_Ehdr header_;
  std::vector<Elf64_Phdr> segments_;
  std::vector<Elf64_Dyn> dynamic_;
  std::set<std::string> symbols_;
};

class Hardening : public testing::Test {
 protected:
  void SetUp() override {
    if (std::string(HPDM_SANITIZERS) != "") GTEST_SKIP() << "the sanitizers stand in their place";
    ASSERT_TRUE(program_.IsElf64());
  }
  const Program program_{kHpdmProgram};
};

TEST_F(Hardening, TheProgramIsLoadedAnywhere) {
  EXPECT_EQ(program_.type(), ET_DYN);
  EXPECT_TRUE(program_.Flags(DT_FLAGS_1) & DF_1_PIE);
}

TEST_F(Hardening, AddressesOfFunctionsAreReadOnlyOnceItRuns) {
  EXPECT_NE(program_.Segment(PT_GNU_RELRO), nullptr);
  EXPECT_TRUE((program_.Flags(DT_FLAGS) & DF_BIND_NOW) || (program_.Flags(DT_FLAGS_1) & DF_1_NOW))
      << "bound while it runs, they would stay writable";
}

TEST_F(Hardening, WritableMemoryIsNeverExecutable) {
  const Elf64_Phdr* stack = program_.Segment(PT_GNU_STACK);
  ASSERT_NE(stack, nullptr) << "without it the stack is code, too";
  EXPECT_FALSE(stack->p_flags & PF_X);
  for (const Elf64_Phdr& segment : program_.segments()) {
    EXPECT_FALSE((segment.p_flags & PF_W) && (segment.p_flags & PF_X)) << segment.p_vaddr;
  }
}

TEST_F(Hardening, AnOverrunArrayOnTheStackEndsTheProgram) {
  EXPECT_TRUE(program_.symbols().contains("__stack_chk_fail"));
}

TEST_F(Hardening, TheLibrarysCopiesKnowTheirBuffers) {
#ifndef NDEBUG
  GTEST_SKIP() << "FORTIFY needs optimisation";
#endif
  // Without FORTIFY no function of the program has such a name.
  int checked = 0;
  for (const std::string& symbol : program_.symbols()) checked += symbol.ends_with("_chk");
  EXPECT_GT(checked, 0);
  EXPECT_TRUE(program_.symbols().contains("__vsnprintf_chk"))
      << "Format (tools/shared/report_text.h)";
}

}  // namespace
}  // namespace hpdm
