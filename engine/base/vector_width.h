#pragma once

#include <cstdint>
#include <initializer_list>

namespace hpdm {

/// The vectors of a processor, by their size. Every x86-64 has those of 16 bytes, AVX2 has 32,
/// AVX-512 has 64.
enum class VectorWidth : std::uint8_t { k16Bytes, k32Bytes, k64Bytes };

/// True if this processor has vectors of that width.
inline bool HasVectors(VectorWidth width) {
#if defined(__x86_64__)
  if (width == VectorWidth::k64Bytes) return __builtin_cpu_supports("avx512f") != 0;
  if (width == VectorWidth::k32Bytes) return __builtin_cpu_supports("avx2") != 0;
#endif
  return width == VectorWidth::k16Bytes;
}

/// Returns the widest vectors of this processor.
inline VectorWidth WidestVectors() {
  for (const VectorWidth width : {VectorWidth::k64Bytes, VectorWidth::k32Bytes}) {
    if (HasVectors(width)) return width;
  }
  return VectorWidth::k16Bytes;
}

}  // namespace hpdm
