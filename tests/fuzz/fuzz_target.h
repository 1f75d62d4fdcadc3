#pragma once

#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>

/// Functions for every reader of foreign bytes. libFuzzer calls them with millions of inputs
/// (entry.cc, tools/fuzz.sh), and fuzz_memory_tests with the kept ones. For any bytes the reader must throw
/// an InputError of one line or keep its promises. Each returns true if the bytes were accepted.
namespace hpdm::fuzz {

using Bytes = std::span<const std::uint8_t>;

/// A reader broke its promise: its result is unsound, or a refusal is incomplete.
class Violation : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

/// Throws Violation unless the condition holds.
#define HPDM_ENSURE(condition)                                                               \
  do {                                                                                       \
    if (!(condition)) {                                                                      \
      throw ::hpdm::fuzz::Violation(std::string(__FILE__) + ":" + std::to_string(__LINE__) + \
                                    ": not so: " #condition);                                \
    }                                                                                        \
  } while (false)

bool LogFile(Bytes bytes);    ///< LogReader, CheckLog, RepairLog, TickReader, LoggedSession.
bool MeshObj(Bytes bytes);    ///< ImportMesh of an OBJ file,
bool MeshPly(Bytes bytes);    ///< a PLY file,
bool MeshStl(Bytes bytes);    ///< an STL file.
bool MeshParts(Bytes bytes);  ///< JoinMesh of encoded parts, each behind its length (2 bytes,
                              ///< the low one first).
bool Message(Bytes bytes);    ///< DecodeMessage and FromMessage of every type.
bool Schema(Bytes bytes);     ///< MessageSchemas of an .lcm text; behind a zero byte, a message
                              ///< without its hash for every type of it.
bool SceneFile(Bytes bytes);  ///< LoadScene.
bool TraceCsv(Bytes bytes);   ///< ReadTraceFile, and the motion that it stands for.

/// Each name has a folder in tests/fuzz/corpus and tests/fuzz/findings.
struct Target {
  const char* name;
  bool (*run)(Bytes bytes);
};
inline constexpr Target kTargets[] = {
    {"LogFile", LogFile},     {"MeshObj", MeshObj}, {"MeshParts", MeshParts},
    {"MeshPly", MeshPly},     {"MeshStl", MeshStl}, {"Message", Message},
    {"SceneFile", SceneFile}, {"Schema", Schema},   {"TraceCsv", TraceCsv}};

}  // namespace hpdm::fuzz
