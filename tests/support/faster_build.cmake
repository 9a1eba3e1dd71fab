# Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
# Included by CMake into every interface package that the test peers are built from. rosidl writes some hundred small C++ files that
# all read the same large headers; compiled in groups they take half the time. The C files cannot be grouped (their static names meet).
function(group_cxx_sources)
  get_property(targets DIRECTORY PROPERTY BUILDSYSTEM_TARGETS)
  foreach(target IN LISTS targets)
    if(target MATCHES "__rosidl_typesupport_(fastrtps_c|c)$")
      set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 16)
    endif()
  endforeach()
endfunction()
cmake_language(DEFER CALL group_cxx_sources)
