// Types of parameters, for whoever handles parameters of plug-ins that it does not know.
#pragma once
#include <kinora/plugin.h>

namespace kinora {

// Numbers that a value takes; strings and structs have none.
constexpr uint32_t componentsOf(Type type) {
  switch (type) {
    case Type::Float:
    case Type::Int:
      return 1;
    case Type::Color:
    case Type::Point:
    case Type::Vector:
    case Type::Normal:
      return 3;
    case Type::Matrix:
      return 16;
    case Type::String:
    case Type::Struct:
      return 0;
  }
  return 0;
}

}  // namespace kinora
