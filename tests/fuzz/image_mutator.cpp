#include "fuzz/image_mutator.h"

#include <zlib.h>

#include <algorithm>
#include <string_view>

namespace kinora::fuzz {

namespace {

uint64_t get(const std::string& s, size_t at, int width, bool bigEndian) {
  uint64_t v = 0;
  for (int i = 0; i < width && at + size_t(i) < s.size(); ++i)
    v |= uint64_t(static_cast<unsigned char>(s[at + size_t(i)])) << (8 * (bigEndian ? width - 1 - i : i));
  return v;
}
void put(std::string& s, size_t at, int width, bool bigEndian, uint64_t v) {
  for (int i = 0; i < width && at + size_t(i) < s.size(); ++i)
    s[at + size_t(i)] = char(v >> (8 * (bigEndian ? width - 1 - i : i)));
}

}  // namespace

void ImageMutator::field(std::string& s, size_t at, int width, bool bigEndian) {
  static constexpr uint64_t kValues[] = {
      0,     1,     2,     3,     4,      7,      8,       16,      32,         64,         255,        256,
      32767, 32768, 65535, 65536, 100000, 131072, 1 << 20, 1 << 28, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF, 0xFFFFFFF0};
  const uint64_t old = get(s, at, width, bigEndian);
  uint64_t v = kValues[below(std::size(kValues))];
  if (below(3) == 0) v = old + below(5) - 2;
  if (below(6) == 0) v = old ^ (uint64_t(1) << below(size_t(8 * width)));
  put(s, at, width, bigEndian, v);
}

// A directory: count, then 12 bytes each of tag, type, count, value (TIFF 6.0, section 2).
void ImageMutator::tiff(std::string& s) {
  const bool big = s[0] == 'M';
  size_t at = get(s, 4, 4, big);
  for (uint32_t skip = below(4); skip > 0; --skip) {
    const size_t n = get(s, at, 2, big), next = get(s, at + 2 + 12 * n, 4, big);
    if (next == 0 || next >= s.size()) break;
    at = next;
  }
  const size_t n = get(s, at, 2, big);
  if (at + 2 >= s.size() || n == 0) return;
  const size_t entry = at + 2 + 12 * below(n);
  switch (below(6)) {
    case 0:
      return field(s, entry, 2, big);
    case 1:
      return field(s, entry + 2, 2, big);
    case 2:
      return field(s, entry + 4, 4, big);
    case 3:
      return field(s, below(2) ? at : at + 2 + 12 * n, below(2) ? 2 : 4, big);
    case 4: {  // what the entry points to
      const size_t to = get(s, entry + 8, 4, big);
      if (to < s.size()) return field(s, to + 4 * below(8), 4, big);
      [[fallthrough]];
    }
    default:
      return field(s, entry + 8, get(s, entry + 2, 2, big) == 3 ? 2 : 4, big);
  }
}

// Length, type, data, checksum of type and data (PNG, section 5).
void ImageMutator::png(std::string& s) {
  size_t at = 8;
  for (uint32_t skip = below(6); skip > 0; --skip) {
    const size_t next = at + 12 + get(s, at, 4, true);
    if (next + 12 > s.size()) break;
    at = next;
  }
  if (at + 12 > s.size()) return;
  size_t length = std::min<size_t>(get(s, at, 4, true), s.size() - at - 12);
  switch (below(6)) {
    case 0:
      field(s, at, 4, true);
      break;
    case 1:
      s[at + 4 + below(4)] ^= char(1 << below(8));
      break;
    case 2:
      s.insert(at, s.substr(at, 12 + length));
      break;
    default:
      if (length > 0) field(s, at + 8 + below(length), 1 << below(3), true);
  }
  if (below(5) == 0 || at + 12 + length > s.size()) return;
  put(s, at + 8 + length, 4, true, crc32(0, reinterpret_cast<const Bytef*>(s.data() + at + 4), unsigned(length + 4)));
}

// FF, marker, length of two bytes with itself (JPEG, B.1.1.4).
void ImageMutator::jpeg(std::string& s) {
  size_t at = 2;
  for (uint32_t skip = below(10); skip > 0; --skip) {
    const size_t next = at + 2 + get(s, at + 2, 2, true);
    if (next + 4 > s.size() || s[next] != '\xff') break;
    at = next;
  }
  if (at + 4 > s.size()) return;
  const size_t length = std::min<size_t>(get(s, at + 2, 2, true), s.size() - at - 2);
  switch (below(5)) {
    case 0:
      return field(s, at + 2, 2, true);
    case 1:
      s[at + 1] ^= char(1 << below(6));
      return;
    case 2:
      s.insert(at, s.substr(at, length + 2));
      return;
    default:
      if (length > 2) field(s, at + 4 + below(length - 2), 1 + int(below(2)), true);
  }
}

// Name, 0, type, 0, size, value; an empty name ends the header; then the offset table.
void ImageMutator::exr(std::string& s) {
  size_t at = 8;
  for (uint32_t skip = below(16); skip > 0 && at < s.size() && s[at] != 0; --skip) {
    const size_t type = s.find('\0', at), size = type == std::string::npos ? type : s.find('\0', type + 1);
    if (size == std::string::npos) return;
    const size_t next = size + 5 + get(s, size + 1, 4, false);
    if (next >= s.size()) break;
    at = next;
  }
  if (at < s.size() && s[at] == 0) return field(s, at + 1 + 8 * below(8), below(2) ? 8 : 4, false);
  const size_t type = s.find('\0', at), size = type == std::string::npos ? type : s.find('\0', type + 1);
  if (size == std::string::npos) return;
  const size_t length = get(s, size + 1, 4, false);
  switch (below(4)) {
    case 0:
      return field(s, size + 1, 4, false);
    case 1:
      s[at + below(size - at)] ^= char(1 << below(7));
      return;
    default:
      field(s, size + 5 + below(std::min<size_t>(length, 400)), below(2) ? 4 : 1, false);
  }
}

void ImageMutator::anywhere(std::string& s) {
  // most of what can go wrong stands at the ends
  const size_t at = below(3) ? below(std::min<size_t>(s.size(), 600)) : below(s.size());
  switch (below(6)) {
    case 0:
      s[at] ^= char(1 << below(8));
      break;
    case 1:
      field(s, at, 1 << below(3), below(2));
      break;
    case 2:
      s.resize(below(2) ? at : below(s.size()));
      break;
    case 3:
      s.erase(at, 1 + below(64));
      break;
    case 4:
      s.insert(at, 1 + below(64), char(below(256)));
      break;
    default:
      for (size_t i = 0; i < 16 && at + i < s.size(); ++i) s[at + i] = char(below(256));
  }
}

std::string ImageMutator::mutate(std::string s, const std::string& other, size_t limit) {
  for (uint32_t n = 1 + below(4); n > 0 && s.size() > 16; --n) {
    const bool structured = below(4) != 0;
    const std::string_view v = s;
    if (below(20) == 0 && other.size() > 16) {
      const size_t cut = below(std::min(s.size(), other.size()));
      s = s.substr(0, cut) + other.substr(cut);
    } else if (structured && (v.starts_with("II") || v.starts_with("MM"))) {
      tiff(s);
    } else if (structured && v.starts_with("\x89PNG")) {
      png(s);
    } else if (structured && v.starts_with("\xff\xd8")) {
      jpeg(s);
    } else if (structured && v.starts_with("\x76\x2f\x31\x01")) {
      exr(s);
    } else {
      anywhere(s);
    }
  }
  if (s.size() > limit) s.resize(limit);
  return s;
}

}  // namespace kinora::fuzz
