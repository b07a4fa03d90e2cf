// Measured light distributions in files of IES LM-63 (1986, 1991, 1995, 2002): candelas by two angles. Called by
// render/ for lights that name one; the stock light filter IesLightFilter evaluates it. It reads text in memory,
// reports nothing and knows no light.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace kinora::light {

// What the angles are: C by vertical angles from straight ahead and horizontal ones about that axis, A and B by
// elevation over and turn about an axis across it (A: the upright one).
enum class IesType : uint8_t { C, B, A };

struct IesProfile {
  IesType type = IesType::C;
  // Degrees, ascending. Symmetries of the file are unfolded: horizontal angles of type C are one, alike all around,
  // or go from 0 to 360, those of A and B are one or go from -90 to 90 at most.
  std::vector<float> vertical, horizontal;
  std::vector<float> candela;  // for each horizontal angle its vertical ones
};

struct IesError {
  uint32_t line = 0;  // 0: no error
  std::string what;
};

inline constexpr size_t kMostIesBytes = 16 << 20;
inline constexpr size_t kMostIesValues = 1 << 20;  // of a file, before symmetries

// `profile` counts only where there is no error.
IesError readIes(std::string_view text, IesProfile& profile);

}  // namespace kinora::light
