# SPDX-License-Identifier: MIT
# cmake -DFROM=shaders -DTO=folder -P break_shaders.cmake: a copy of the shaders with one error, as a CMake project of
# its own. The error is small: one coefficient of the lens is taken for another, which moves undistorted centroids by
# tenths of a pixel and nothing else.
file(REMOVE_RECURSE "${TO}/shaders")
file(COPY "${FROM}" DESTINATION "${TO}")
set(file "${TO}/shaders/lib/undistort.glsl")
file(READ "${file}" right)
string(REPLACE "lens.p1" "lens.p2" wrong "${right}")
if(wrong STREQUAL right)
  message(FATAL_ERROR "shaders/lib/undistort.glsl no longer reads lens.p1: plant another error in break_shaders.cmake")
endif()
file(WRITE "${file}" "${wrong}")
file(WRITE "${TO}/CMakeLists.txt" "# SPDX-License-Identifier: MIT
cmake_minimum_required(VERSION 3.25)
project(broken_shaders LANGUAGES NONE)
add_subdirectory(shaders)
")
