// SPDX-License-Identifier: MIT
// What the fake driver answers.
#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>

#include "tests/unit/capture/fake_v4l2.hpp"

namespace glint::test {
namespace {

void put_text(void* field, std::size_t bytes, const std::string& text) {
  std::memset(field, 0, bytes);
  std::memcpy(field, text.data(), std::min(bytes - 1, text.size()));
}

std::uint32_t row_bytes(std::uint32_t fourcc, std::uint32_t width_px) {
  return fourcc == V4L2_PIX_FMT_YUYV ? 2 * width_px : width_px;
}

int enum_format(const FakeCamera& camera, v4l2_fmtdesc& entry) {
  if (entry.index >= camera.formats.size()) return -EINVAL;
  entry.pixelformat = camera.formats[entry.index].fourcc;
  put_text(entry.description, sizeof entry.description, "a format");
  return 0;
}

const FakeFormat* format_of(const FakeCamera& camera, std::uint32_t fourcc) {
  const auto found = std::find_if(camera.formats.begin(), camera.formats.end(),
                                  [&](const FakeFormat& format) { return format.fourcc == fourcc; });
  return found == camera.formats.end() ? nullptr : &*found;
}

int enum_size(const FakeCamera& camera, v4l2_frmsizeenum& entry) {
  const FakeFormat* const format = format_of(camera, entry.pixel_format);
  if (format == nullptr || entry.index >= (format->stepwise ? 1 : format->sizes.size())) return -EINVAL;
  if (format->stepwise) {
    const FakeSize &least = format->sizes[0], &most = format->sizes[1];
    entry.type = V4L2_FRMSIZE_TYPE_STEPWISE;
    entry.stepwise = {least.width_px, most.width_px, 8, least.height_px, most.height_px, 8};
  } else {
    entry.type = V4L2_FRMSIZE_TYPE_DISCRETE;
    entry.discrete = {format->sizes[entry.index].width_px, format->sizes[entry.index].height_px};
  }
  return 0;
}

int enum_interval(const FakeCamera& camera, v4l2_frmivalenum& entry) {
  const FakeFormat* const format = format_of(camera, entry.pixel_format);
  if (format == nullptr) return -EINVAL;
  for (const FakeSize& size : format->sizes) {
    if (size.width_px != entry.width || size.height_px != entry.height) continue;
    if (entry.index >= size.rates_hz.size()) return -EINVAL;
    entry.type = V4L2_FRMIVAL_TYPE_DISCRETE;
    entry.discrete = {1000, static_cast<std::uint32_t>(std::lround(size.rates_hz[entry.index] * 1000.0))};
    return 0;
  }
  return -EINVAL;
}

void describe(const FakeCamera& camera, v4l2_format& format) {
  v4l2_pix_format& pix = format.fmt.pix;
  pix.width = camera.width_px;
  pix.height = camera.height_px;
  pix.pixelformat = camera.fourcc;
  pix.field = V4L2_FIELD_NONE;
  const bool jpeg = camera.fourcc == V4L2_PIX_FMT_MJPEG;
  pix.bytesperline = jpeg ? 0 : row_bytes(camera.fourcc, camera.width_px) + camera.more_stride_bytes;
  pix.sizeimage = (jpeg ? 2 * camera.width_px : pix.bytesperline) * camera.height_px;
  if (camera.fourcc == V4L2_PIX_FMT_NV12) pix.sizeimage += pix.sizeimage / 2;
}

/// As drivers do: what is nearest to the wish.
void set_format(FakeCamera& camera, v4l2_format& wish) {
  const FakeFormat* format = format_of(camera, wish.fmt.pix.pixelformat);
  if (format == nullptr) format = &camera.formats.front();
  camera.fourcc = format->fourcc;
  camera.width_px = camera.height_px = 0;
  for (const FakeSize& size : format->sizes) {
    if (size.width_px == wish.fmt.pix.width && size.height_px == wish.fmt.pix.height) {
      camera.width_px = size.width_px;
      camera.height_px = size.height_px;
    }
  }
  if (format->stepwise || format->sizes.empty()) {
    camera.width_px = wish.fmt.pix.width / 8 * 8;
    camera.height_px = wish.fmt.pix.height / 8 * 8;
  } else if (camera.width_px == 0) {
    camera.width_px = format->sizes.front().width_px;
    camera.height_px = format->sizes.front().height_px;
  }
  describe(camera, wish);
}

void fill_rate(const FakeCamera& camera, v4l2_streamparm& parameters) {
  parameters.parm.capture.capability = camera.sets_rate ? V4L2_CAP_TIMEPERFRAME : 0;
  parameters.parm.capture.timeperframe = {1000, static_cast<std::uint32_t>(camera.set_rate_hz * 1000.0)};
}

void set_rate(FakeCamera& camera, v4l2_streamparm& parameters) {
  const v4l2_fract& wish = parameters.parm.capture.timeperframe;
  const double wanted = static_cast<double>(wish.denominator) / wish.numerator;
  constexpr double kNone = 1e9;
  double best = camera.hidden_rate_hz > 0.0 ? camera.hidden_rate_hz : kNone;
  const FakeFormat* const format = format_of(camera, camera.fourcc);
  for (const FakeSize& size : format == nullptr ? std::vector<FakeSize>{} : format->sizes) {
    if (size.width_px != camera.width_px || size.height_px != camera.height_px) continue;
    for (const double rate : size.rates_hz) {
      if (std::abs(rate - wanted) < std::abs(best - wanted)) best = rate;
    }
  }
  if (camera.sets_rate && best < kNone) camera.set_rate_hz = best;
  fill_rate(camera, parameters);
}

int query_control(const FakeCamera& camera, v4l2_query_ext_ctrl& entry) {
  const std::uint32_t after = entry.id & ~V4L2_CTRL_FLAG_NEXT_CTRL;
  const FakeControl* next = nullptr;
  for (const FakeControl& control : camera.controls) {
    if (control.id > after && (next == nullptr || control.id < next->id)) next = &control;
  }
  if (next == nullptr) return -EINVAL;
  entry = {};
  entry.id = next->id;
  entry.type = next->type;
  put_text(entry.name, sizeof entry.name, next->name);
  entry.minimum = next->lowest;
  entry.maximum = next->highest;
  entry.step = static_cast<std::uint64_t>(next->step);
  entry.default_value = next->usual;
  entry.flags = next->flags;
  return 0;
}

FakeControl* control_of(FakeCamera& camera, std::uint32_t id) {
  const auto found = std::find_if(camera.controls.begin(), camera.controls.end(),
                                  [&](const FakeControl& control) { return control.id == id; });
  return found == camera.controls.end() ? nullptr : &*found;
}

int query_menu(FakeCamera& camera, v4l2_querymenu& entry) {
  const FakeControl* const control = control_of(camera, entry.id);
  if (control == nullptr || entry.index >= control->menu.size() || control->menu[entry.index].empty())
    return -EINVAL;
  put_text(entry.name, sizeof entry.name, control->menu[entry.index]);
  return 0;
}

int transfer_control(FakeCamera& camera, v4l2_ext_controls& all, bool set) {
  v4l2_ext_control& one = all.controls[0];
  FakeControl* const control = control_of(camera, one.id);
  if (control == nullptr) return -EINVAL;
  if (!set) {
    one.value = static_cast<std::int32_t>(control->value);
    return 0;
  }
  const FakeControl* const gate = control->until == 0 ? nullptr : control_of(camera, control->until);
  if (control->refusal != 0 && (gate == nullptr || gate->value != 1)) return -control->refusal;
  control->value = one.value;
  return 0;
}

int request_buffers(FakeCamera& camera, v4l2_requestbuffers& request) {
  if (request.memory == V4L2_MEMORY_USERPTR && !camera.takes_pointers) return -EINVAL;
  if (camera.streaming) return -EBUSY;
  request.count = std::min(request.count, camera.most_buffers);
  v4l2_format format{};
  describe(camera, format);
  camera.memory = request.memory;
  camera.waiting.clear();
  camera.done.clear();
  camera.buffers = std::vector<FakeCamera::Buffer>(request.count);
  for (FakeCamera::Buffer& buffer : camera.buffers) {
    if (request.memory != V4L2_MEMORY_MMAP) continue;
    buffer.memory.resize(format.fmt.pix.sizeimage);
    buffer.pointer = buffer.memory.data();
    buffer.bytes = buffer.memory.size();
  }
  return 0;
}

int queue(FakeCamera& camera, const v4l2_buffer& request) {
  if (request.index >= camera.buffers.size() || camera.buffers[request.index].queued) return -EINVAL;
  FakeCamera::Buffer& buffer = camera.buffers[request.index];
  if (camera.memory == V4L2_MEMORY_USERPTR) {
    v4l2_format format{};
    describe(camera, format);
    if (request.length < format.fmt.pix.sizeimage) return -EINVAL;
    buffer.pointer = reinterpret_cast<std::uint8_t*>(request.m.userptr);
    buffer.bytes = request.length;
  }
  buffer.queued = true;
  camera.waiting.push_back(request.index);
  return 0;
}

int dequeue(FakeCamera& camera, v4l2_buffer& filled) {
  if (!camera.streaming) return -EINVAL;
  if (camera.done.empty()) return -EAGAIN;
  filled = camera.done.front();
  camera.done.erase(camera.done.begin());
  camera.buffers[filled.index].queued = false;
  return 0;
}

}  // namespace

int FakeV4l2::answer(FakeCamera& camera, unsigned long request, void* argument) {
  if (camera.fourcc == 0 && !camera.formats.empty()) {  // as after plugging in
    camera.fourcc = camera.formats.front().fourcc;
    if (!camera.formats.front().sizes.empty()) {
      camera.width_px = camera.formats.front().sizes.front().width_px;
      camera.height_px = camera.formats.front().sizes.front().height_px;
    }
  }
  switch (request) {
    case VIDIOC_QUERYCAP: {
      auto& capability = *static_cast<v4l2_capability*>(argument);
      put_text(capability.card, sizeof capability.card, camera.card);
      put_text(capability.driver, sizeof capability.driver, camera.driver);
      capability.capabilities = camera.abilities | V4L2_CAP_DEVICE_CAPS;
      capability.device_caps = camera.abilities;
      return 0;
    }
    case VIDIOC_ENUM_FMT:
      return enum_format(camera, *static_cast<v4l2_fmtdesc*>(argument));
    case VIDIOC_ENUM_FRAMESIZES:
      return enum_size(camera, *static_cast<v4l2_frmsizeenum*>(argument));
    case VIDIOC_ENUM_FRAMEINTERVALS:
      return enum_interval(camera, *static_cast<v4l2_frmivalenum*>(argument));
    case VIDIOC_G_FMT:
      describe(camera, *static_cast<v4l2_format*>(argument));
      return 0;
    case VIDIOC_S_FMT:
      set_format(camera, *static_cast<v4l2_format*>(argument));
      return 0;
    case VIDIOC_G_PARM:
      fill_rate(camera, *static_cast<v4l2_streamparm*>(argument));
      return 0;
    case VIDIOC_S_PARM:
      set_rate(camera, *static_cast<v4l2_streamparm*>(argument));
      return 0;
    case VIDIOC_QUERY_EXT_CTRL:
      return query_control(camera, *static_cast<v4l2_query_ext_ctrl*>(argument));
    case VIDIOC_QUERYMENU:
      return query_menu(camera, *static_cast<v4l2_querymenu*>(argument));
    case VIDIOC_G_EXT_CTRLS:
      return transfer_control(camera, *static_cast<v4l2_ext_controls*>(argument), false);
    case VIDIOC_S_EXT_CTRLS:
      return transfer_control(camera, *static_cast<v4l2_ext_controls*>(argument), true);
    case VIDIOC_REQBUFS:
      return request_buffers(camera, *static_cast<v4l2_requestbuffers*>(argument));
    case VIDIOC_QUERYBUF: {
      auto& info = *static_cast<v4l2_buffer*>(argument);
      if (info.index >= camera.buffers.size()) return -EINVAL;
      info.length = static_cast<std::uint32_t>(camera.buffers[info.index].memory.size());
      info.m.offset = info.index;
      return 0;
    }
    case VIDIOC_QBUF:
      return queue(camera, *static_cast<v4l2_buffer*>(argument));
    case VIDIOC_DQBUF:
      return dequeue(camera, *static_cast<v4l2_buffer*>(argument));
    case VIDIOC_STREAMON:
      camera.streaming = true;
      camera.pulse = 0;
      camera.started = now() - now().time_since_epoch() % period_of(camera);  // one trigger for all
      return 0;
    case VIDIOC_STREAMOFF:
      camera.streaming = false;
      camera.waiting.clear();
      camera.done.clear();
      for (FakeCamera::Buffer& buffer : camera.buffers) buffer.queued = false;
      return 0;
    default:
      return -ENOTTY;
  }
}

}  // namespace glint::test
