// SPDX-License-Identifier: MIT
// Importing calibrations: each format's way of writing the same cameras gives the same result, and what
// cannot be converted is refused with a reason.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <iomanip>
#include <random>

#include "host/config/import_calibration.hpp"
#include "host/config/rig.hpp"
#include "tests/unit/config/config_fixture.hpp"

namespace glint {
namespace {

using test::error_of;
using test::TempFolder;
using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::StartsWith;
using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// A camera as other tools know it: X_cam = R X_world + t, t in millimetres.
struct Truth {
  Eigen::Matrix3d k = (Eigen::Matrix3d() << 912.25, 0, 640.5, 0, 915.75, 399.125, 0, 0, 1).finished();
  Eigen::VectorXd d = (Eigen::VectorXd(5) << -0.25, 0.125, 0.001, -0.002, 0.0625).finished();
  Eigen::Matrix3d r;
  Eigen::Vector3d rodrigues, t_mm;

  explicit Truth(unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    const Eigen::Vector3d axis =
        Eigen::Vector3d(uniform(random), uniform(random), uniform(random)).normalized();
    rodrigues = axis * (1.5 + uniform(random));
    r = Eigen::AngleAxisd(rodrigues.norm(), axis).toRotationMatrix();
    t_mm = Eigen::Vector3d(uniform(random), uniform(random), 3.0) * 1000.0;
  }
};

std::string row_text(const Matrix& m, const char* separator = ", ") {
  std::ostringstream out;
  out << std::setprecision(17);
  for (Eigen::Index n = 0; n < m.size(); ++n) out << (n ? separator : "") << m.data()[n];
  return out.str();
}

std::string rows_text(const Matrix& m) {
  std::string text;
  for (Eigen::Index r = 0; r < m.rows(); ++r) text += (r ? ", [" : "[") + row_text(m.row(r)) + "]";
  return "[" + text + "]";
}

std::string yaml_matrix(const std::string& key, const Matrix& m) {
  return key + ": !!opencv-matrix\n   rows: " + std::to_string(m.rows()) +
         "\n   cols: " + std::to_string(m.cols()) + "\n   dt: d\n   data: [ " + row_text(m) + " ]\n";
}

std::string xml_matrix(const std::string& key, const Matrix& m) {
  return "<" + key + " type_id=\"opencv-matrix\">\n  <rows>" + std::to_string(m.rows()) +
         "</rows>\n  <cols>" + std::to_string(m.cols()) + "</cols>\n  <dt>d</dt>\n  <data>\n    " +
         row_text(m, "\n    ") + "</data></" + key + ">\n";
}

Matrix pose34(const Truth& truth) {
  Matrix pose(3, 4);
  pose << truth.r, truth.t_mm;
  return pose;
}

std::string yaml_camera(const Truth& truth) {
  return "%YAML:1.0\n---\nimage_width: 1280\nimage_height: 800\n" + yaml_matrix("camera_matrix", truth.k) +
         yaml_matrix("distortion_coefficients", truth.d) + yaml_matrix("extrinsics", pose34(truth));
}

std::string xml_camera(const Truth& truth) {
  return "<?xml version=\"1.0\"?>\n<opencv_storage>\n<image_width>1280</image_width>\n"
         "<image_height>800</image_height>\n" +
         xml_matrix("cameraMatrix", truth.k) + xml_matrix("distCoeffs", truth.d) +
         xml_matrix("extrinsics", pose34(truth)) + "</opencv_storage>\n";
}

std::string json_camera(const Truth& truth, const std::string& name) {
  return "{\"camera\": \"" + name + "\", \"size\": [1280, 800], \"K\": " + rows_text(truth.k) +
         ", \"dist_k1k2p1p2k3\": [" + row_text(truth.d) + "], \"R\": " + rows_text(truth.r) +
         ", \"t_mm\": [" + row_text(truth.t_mm) + "]}";
}

/// A camera table of aniposelib or caliscope.
std::string toml_camera(const Truth& truth, const std::string& header, bool as_matrix) {
  const Eigen::Vector3d t = as_matrix ? Eigen::Vector3d(truth.t_mm / 1000.0) : truth.t_mm;
  return header + "\nsize = [ 1280, 800,]\nmatrix = " + rows_text(truth.k) + "\ndistortions = [ " +
         row_text(truth.d) +
         ",]\nrotation = " + (as_matrix ? rows_text(truth.r) : "[ " + row_text(truth.rodrigues) + ",]") +
         "\ntranslation = [ " + row_text(t) + ",]\n\n";
}

std::string openlpt_camera(const Truth& truth) {
  std::string k, r;
  for (int n = 0; n < 3; ++n) {
    k += row_text(truth.k.row(n), ",") + "\n";
    r += row_text(truth.r.row(n), ",") + "\n";
  }
  return "# Camera Model: (PINHOLE/POLYNOMIAL)\nPINHOLE\n# Camera Calibration Error: \nNone\n"
         "# Image Size: (n_row,n_col)\n800,1280\n# Camera Matrix: \n" +
         k + "# Distortion Coefficients: \n" + row_text(truth.d, ",") + "\n# Rotation Vector: \n" +
         row_text(truth.rodrigues, ",") + "\n# Rotation Matrix: \n" + r + "# Translation Vector: \n" +
         row_text(truth.t_mm, ",") + "\n";
}

void expect_is(const CameraCalibration& camera, const Truth& truth) {
  EXPECT_EQ(camera.width_px, 1280u);
  EXPECT_EQ(camera.height_px, 800u);
  EXPECT_EQ(camera.fx_px, truth.k(0, 0));
  EXPECT_EQ(camera.fy_px, truth.k(1, 1));
  EXPECT_EQ(camera.cx_px, truth.k(0, 2));
  EXPECT_EQ(camera.cy_px, truth.k(1, 2));
  for (int n = 0; n < 5; ++n) {
    EXPECT_EQ(camera.k1_k2_p1_p2_k3[static_cast<std::size_t>(n)], n < truth.d.size() ? truth.d[n] : 0.0);
  }
  const Eigen::Vector3d x_in_world(0.3, -0.4, 0.5);
  const Eigen::Vector3d x_in_camera = camera.world_from_camera.inverse() * x_in_world;
  EXPECT_LT((x_in_camera - (truth.r * x_in_world + truth.t_mm / 1000.0)).norm(), 1e-12);
  EXPECT_NEAR(camera.world_from_camera.rotation.norm(), 1.0, 1e-15);
}

class ImportFormats : public ::testing::Test {
 protected:
  Calibration import(const std::vector<std::string>& texts) {
    std::vector<std::filesystem::path> files;
    for (std::size_t n = 0; n < texts.size(); ++n) {
      files.push_back(folder_.write("file" + std::to_string(n + 1), texts[n]));
    }
    notes_.clear();
    const Calibration calibration = import_calibration(files, options_, &notes_);
    // Whatever is imported can be written and read back without loss.
    write_calibration(folder_ / "out.toml", calibration, true);
    test::expect_same(read_calibration(folder_ / "out.toml"), calibration);
    return calibration;
  }
  std::string complaint(const std::string& text) {
    return folder_.strip(error_of([&] { import({text}); }));
  }

  std::string replaced(std::string text, const std::string& from, const std::string& to) {
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
  }

  TempFolder folder_;
  ImportOptions options_;
  std::vector<std::string> notes_;
  const Truth a_{1}, b_{2};
};

TEST_F(ImportFormats, OpenCvYamlOneCameraPerFile) {
  options_.metres_per_unit = 0.001;
  const Calibration c = import({yaml_camera(a_), yaml_camera(b_)});
  ASSERT_EQ(c.cameras.size(), 2u);
  expect_is(c.cameras[0], a_);
  expect_is(c.cameras[1], b_);
  EXPECT_EQ(c.cameras[0].name, "file1");
  EXPECT_EQ(c.made_from, "OpenCV: file1 file2");
}

TEST_F(ImportFormats, OpenCvXmlOneCameraPerFile) {
  options_.metres_per_unit = 0.001;
  const Calibration c = import({xml_camera(a_), xml_camera(b_)});
  ASSERT_EQ(c.cameras.size(), 2u);
  expect_is(c.cameras[0], a_);
  expect_is(c.cameras[1], b_);
}

TEST_F(ImportFormats, OpenCvStereoPairInTwoFilesHasTheFirstCameraAsWorld) {
  options_ = {.metres_per_unit = 0.001, .names = {"left", "right"}, .width_px = 1280, .height_px = 800};
  const std::string intrinsics = "%YAML:1.0\n---\n" + yaml_matrix("M1", a_.k) + yaml_matrix("D1", a_.d) +
                                 yaml_matrix("M2", b_.k) + yaml_matrix("D2", b_.d);
  const std::string extrinsics = "%YAML:1.0\n---\n" + yaml_matrix("R", b_.r) + yaml_matrix("T", b_.t_mm) +
                                 yaml_matrix("R1", Matrix::Identity(3, 3)) + yaml_matrix("P1", pose34(a_));
  const Calibration c = import({intrinsics, extrinsics});
  ASSERT_EQ(c.cameras.size(), 2u);
  EXPECT_EQ(c.cameras[0].name, "left");
  EXPECT_TRUE(c.cameras[0].world_from_camera.translation.isZero(0.0));
  EXPECT_EQ(c.cameras[0].world_from_camera.rotation.w(), 1.0);
  expect_is(c.cameras[1], b_);
  EXPECT_TRUE(notes_.empty());
}

TEST_F(ImportFormats, OpenCvStereoPairInOneXmlFile) {
  options_.metres_per_unit = 0.001;
  const Calibration c =
      import({"<?xml version=\"1.0\"?>\n<opencv_storage>\n<imageSize>1280 800</imageSize>\n" +
              xml_matrix("cameraMatrix1", a_.k) + xml_matrix("distCoeffs1", a_.d) +
              xml_matrix("cameraMatrix2", b_.k) + xml_matrix("distCoeffs2", b_.d) + xml_matrix("R", b_.r) +
              xml_matrix("T", b_.t_mm) + "</opencv_storage>\n"});
  ASSERT_EQ(c.cameras.size(), 2u);
  EXPECT_EQ(c.cameras[0].name, "cam1");
  expect_is(c.cameras[1], b_);
}

TEST_F(ImportFormats, OpenCvPosesFromRodriguesVectors) {
  options_.metres_per_unit = 0.001;
  const std::string text = "%YAML:1.0\n---\nimage_width: 1280\nimage_height: 800\n" +
                           yaml_matrix("camera_matrix", a_.k) + yaml_matrix("distortion_coefficients", a_.d) +
                           yaml_matrix("rvec", a_.rodrigues) + yaml_matrix("tvec", a_.t_mm);
  expect_is(import({text}).cameras[0], a_);
}

TEST_F(ImportFormats, OpenCvWithoutPosesSaysSo) {
  options_.width_px = 1280;
  options_.height_px = 800;
  const Calibration c = import({"%YAML:1.0\n" + yaml_matrix("M1", a_.k) + yaml_matrix("D1", a_.d) +
                                yaml_matrix("M2", b_.k) + yaml_matrix("D2", b_.d)});
  EXPECT_EQ(c.cameras.size(), 2u);
  EXPECT_THAT(notes_, ElementsAre(HasSubstr("all cameras stand at the origin")));
}

TEST_F(ImportFormats, Json) {
  const Calibration c =
      import({"{\"cameras\": [" + json_camera(a_, "north") + ",\n" + json_camera(b_, "south") + "]}"});
  ASSERT_EQ(c.cameras.size(), 2u);
  EXPECT_EQ(c.cameras[0].name, "north");
  expect_is(c.cameras[0], a_);
  expect_is(c.cameras[1], b_);
}

TEST_F(ImportFormats, AniposelibIsInTheUnitOfItsBoard) {
  const std::string text = toml_camera(a_, "[cam_0]\nname = \"A\"", false) +
                           toml_camera(b_, "[cam_1]\nname = \"B\"", false) +
                           "[metadata]\nadjusted = false\nerror = 0.5\n";
  EXPECT_THAT(complaint(text), HasSubstr("say it with --unit"));
  options_.metres_per_unit = 0.001;
  const Calibration c = import({text});
  ASSERT_EQ(c.cameras.size(), 2u);
  EXPECT_EQ(c.cameras[1].name, "B");
  expect_is(c.cameras[0], a_);
  expect_is(c.cameras[1], b_);
  EXPECT_THAT(c.made_from, StartsWith("aniposelib:"));
}

TEST_F(ImportFormats, CaliscopeIsInMetres) {
  for (const char* style : {"[cameras.", "[cam_"}) {
    const Calibration c = import({toml_camera(a_, style + std::string("0]\ncam_id = 0\nerror = 0.5"), true) +
                                  toml_camera(b_, style + std::string("1]\ncam_id = 1"), true)});
    ASSERT_EQ(c.cameras.size(), 2u);
    EXPECT_EQ(c.cameras[0].name, "cam_0");
    EXPECT_EQ(c.cameras[0].rms_px, 0.5);
    expect_is(c.cameras[0], a_);
    expect_is(c.cameras[1], b_);
    EXPECT_THAT(c.made_from, StartsWith("caliscope:"));
  }
}

TEST_F(ImportFormats, CamerasKeepTheOrderOfTheFile) {
  std::string text;
  for (int n = 0; n < 12; ++n) {
    text += toml_camera(Truth(static_cast<unsigned>(n)), "[cam_" + std::to_string(n) + "]", true);
  }
  const Calibration c = import({text});
  ASSERT_EQ(c.cameras.size(), 12u);
  EXPECT_EQ(c.cameras[2].name, "cam_2");
  EXPECT_EQ(c.cameras[10].name, "cam_10");
  expect_is(c.cameras[10], Truth(10));
}

TEST_F(ImportFormats, IgnoredCaliscopeCamerasAreLeftOutAloud) {
  const Calibration c = import({toml_camera(a_, "[cameras.0]\nignore = true", true) +
                                toml_camera(b_, "[cameras.1]\nignore = false", true)});
  ASSERT_EQ(c.cameras.size(), 1u);
  EXPECT_EQ(c.cameras[0].name, "cam_1");
  EXPECT_THAT(notes_, ElementsAre(EndsWith("cam_0 is marked \"ignore\" and left out")));
}

TEST_F(ImportFormats, OpenLptKeepsTheNegativeFocalLength) {
  Truth truth(3);
  truth.k(1, 1) = -10148.25;
  const Calibration c = import({openlpt_camera(truth)});
  ASSERT_EQ(c.cameras.size(), 1u);
  expect_is(c.cameras[0], truth);
}

TEST_F(ImportFormats, FourCoefficientsMeanNoThirdRadialOne) {
  Truth truth(4);
  truth.d.conservativeResize(4);
  expect_is(import({openlpt_camera(truth)}).cameras[0], truth);
}

TEST_F(ImportFormats, MoreCoefficientsOnlyIfTheyAreZero) {
  Truth truth(5);
  const Eigen::VectorXd five = truth.d;
  for (const int count : {8, 12, 14}) {
    truth.d = Eigen::VectorXd::Zero(count);
    truth.d.head(5) = five;
    Truth expected(5);
    expect_is(import({openlpt_camera(truth)}).cameras[0], expected);
    truth.d[6] = 0.01;
    EXPECT_THAT(complaint(openlpt_camera(truth)),
                StartsWith("file1: " + std::to_string(count) +
                           " distortion coefficients, of which number 7 is 0.01;"));
  }
  truth.d = Eigen::VectorXd::Zero(3);
  EXPECT_THAT(complaint(openlpt_camera(truth)), HasSubstr("3 distortion coefficients; there must be 4"));
}

TEST_F(ImportFormats, ARoundedRotationBecomesTheNearestExactOne) {
  Truth rounded(6);
  rounded.r = (rounded.r * 1e6).array().round().matrix() / 1e6;
  const Calibration c = import({"{\"cameras\": [" + json_camera(rounded, "a") + "]}"});
  const Eigen::Matrix3d r = c.cameras[0].world_from_camera.rotation.conjugate().toRotationMatrix();
  EXPECT_LT((r.transpose() * r - Eigen::Matrix3d::Identity()).norm(), 1e-14);
  EXPECT_LT((r - Truth(6).r).norm(), 2e-6);
}

TEST_F(ImportFormats, WhatIsNoRotationIsRefused) {
  Truth truth(7);
  truth.r(1, 1) += 0.01;
  EXPECT_THAT(complaint("{\"cameras\": [" + json_camera(truth, "a") + "]}"),
              StartsWith("file1: cameras[0]: the rotation is none: R^T R differs from the identity by 0.0"));
  Truth mirrored(7);
  mirrored.r.row(2) *= -1.0;
  EXPECT_THAT(complaint("{\"cameras\": [" + json_camera(mirrored, "a") + "]}"), HasSubstr("is mirrored"));
}

TEST_F(ImportFormats, WhatTheCameraModelLacksIsRefused) {
  Truth skewed(8);
  skewed.k(0, 1) = 2.5;
  EXPECT_THAT(complaint(openlpt_camera(skewed)), HasSubstr("has a skew of 2.5"));
  EXPECT_THAT(complaint(replaced(openlpt_camera(a_), "\nPINHOLE", "\nPOLYNOMIAL")),
              StartsWith("file1:1:1: the camera model is POLYNOMIAL"));
  EXPECT_THAT(complaint(toml_camera(a_, "[cam_0]\nfisheye = true", true)),
              StartsWith("file1:2:11: cam_0 has a fisheye"));
  EXPECT_THAT(complaint(replaced(yaml_camera(a_), "---\n", "---\ndistortion_model: equidistant\n")),
              StartsWith("file1:3:19: the lens model \"equidistant\""));
}

TEST_F(ImportFormats, SizesAndNamesFromTheCommandLine) {
  const std::string sizeless = replaced(yaml_camera(a_), "image_width: 1280\nimage_height: 800\n", "");
  options_.metres_per_unit = 0.001;
  EXPECT_THAT(complaint(sizeless),
              EndsWith("the file does not tell the size of the image; add --size WIDTHxHEIGHT"));
  options_.width_px = 1280;
  options_.height_px = 800;
  expect_is(import({sizeless}).cameras[0], a_);
  options_.height_px = 720;
  EXPECT_THAT(complaint(yaml_camera(a_)), HasSubstr("the file says 1280x800, --size says 1280x720"));
  options_.height_px = 800;
  options_.names = {"a", "b"};
  EXPECT_THAT(complaint(yaml_camera(a_)), HasSubstr("--names gives 2 names for 1 cameras"));
  EXPECT_THAT(error_of([&] {
                options_.names = {"a", "a"};
                import({yaml_camera(a_), yaml_camera(b_)});
              }),
              HasSubstr("two cameras are called \"a\""));
}

TEST_F(ImportFormats, PosesMustBeThereForAllOrNone) {
  EXPECT_THAT(complaint(toml_camera(a_, "[cam_0]", true) + "[cam_1]\nsize = [1280, 800]\nmatrix = " +
                        rows_text(b_.k) + "\ndistortions = [0, 0, 0, 0]\n"),
              EndsWith("this camera has no pose (rotation and translation), but others have"));
}

TEST_F(ImportFormats, AnOpenCvFileWithoutDistortionIsNotTakenForAnIdealLens) {
  EXPECT_EQ(complaint(yaml_camera(a_).substr(0, yaml_camera(a_).find("distortion_"))),
            "file1:5:16: the distortion coefficients of this camera are missing (an ideal lens has zeros)");
}

TEST_F(ImportFormats, BrokenFilesAreNamedWithTheirPlace) {
  EXPECT_EQ(complaint(""),
            "file1: not a calibration format that is known here (json, opencv, anipose, caliscope, openlpt)");
  EXPECT_EQ(complaint("{\"cameras\": [\n  {,}]}"), "file1:2:4: not JSON");
  EXPECT_EQ(complaint("{\"cameras\": [{}]}"), "file1: cameras[0]: \"K\" is missing");
  EXPECT_EQ(complaint("{\"cameras\": []}"), "file1: there is no camera in it");
  EXPECT_THAT(complaint("%YAML:1.0\n---\ncamera_matrix: [1, 2\nimage_width: 3\n"),
              StartsWith("file1:4:12: not YAML: "));
  EXPECT_THAT(complaint("%YAML:1.0\n" + std::string(50000, '[')), HasSubstr("not YAML"));
  EXPECT_EQ(complaint(replaced(yaml_camera(a_), "rows: 3", "rows: 4")),
            "file1:5:16: the matrix says 4x3 but holds 9 numbers");
  EXPECT_EQ(complaint(replaced(yaml_camera(a_), "data: [ 912.25", "data: [ .Nan")),
            "file1:9:12: \".Nan\" is not a finite number");
  EXPECT_THAT(complaint("<?xml version=\"1.0\"?>\n<opencv_storage>\n<a>3</b>\n</opencv_storage>"),
              StartsWith("file1:3:"));
  EXPECT_EQ(complaint("<?xml version=\"1.0\"?>\n<other/>\n"),
            "file1:1:1: the element <opencv_storage> is missing");
  EXPECT_THAT(complaint("[cam_0]\nsize = [1280 800]\n"), StartsWith("file1:2:14: not TOML: "));
  EXPECT_EQ(complaint("[cam_0]\nsize = [1280, 800]\n"), "file1:1:1: cam_0 lacks \"matrix\"");
  EXPECT_EQ(complaint("[cam_0]\nsize = [1280, 0]\n"),
            "file1:2:8: the image size must be whole numbers from 1 to 65535, not 0");
  EXPECT_EQ(complaint(replaced(openlpt_camera(a_), "800,1280", "800,wide")),
            "file1:6:1: \"wide\" is not a number");
}

TEST_F(ImportFormats, ADistortionOfNanIsRefused) {
  const std::string text = toml_camera(a_, "[cam_0]", true);
  EXPECT_THAT(complaint(replaced(text, "distortions = [ -0.25", "distortions = [ nan")),
              HasSubstr("a distortion coefficient is not finite"));
  EXPECT_THAT(complaint(replaced(text, "translation = [ ", "translation = [ inf, ")),
              HasSubstr("must have 3 numbers"));
}

TEST_F(ImportFormats, OurOwnFilesNeedNoImport) {
  Calibration own;
  own.cameras.resize(1);
  own.cameras[0].name = "a";
  EXPECT_THAT(complaint(to_toml(own)), EndsWith("is a calibration file of glint already; use it as it is"));
}

TEST_F(ImportFormats, TheFormatCanBeForced) {
  options_.format = CalibrationFormat::OpenCv;
  EXPECT_THAT(complaint(toml_camera(a_, "[cam_0]", true)), StartsWith("file1:"));
  options_.format = CalibrationFormat::Anipose;
  EXPECT_THAT(complaint(toml_camera(a_, "[cam_0]", true)), HasSubstr("say it with --unit"));
  EXPECT_EQ(calibration_format_of("openlpt"), CalibrationFormat::OpenLpt);
  EXPECT_EQ(calibration_format_of("OpenLPT"), std::nullopt);
}

TEST_F(ImportFormats, EveryTruncationIsAnErrorNotACrash) {
  options_.metres_per_unit = 1.0;
  for (const std::string& text :
       {yaml_camera(a_), xml_camera(a_), "{\"cameras\": [" + json_camera(a_, "a") + "]}",
        toml_camera(a_, "[cam_0]", true), openlpt_camera(a_)}) {
    // A file that lost its pose or the end of its last number can be valid: only crashes count there.
    for (std::size_t length = 0; length < text.size(); ++length) {
      const auto file = folder_.write("cut", text.substr(0, length));
      const std::string message = error_of([&] { import_calibration({file}, options_); });
      if (length < text.size() / 3) {
        EXPECT_NE(message, "no error") << text.substr(0, length);
      }
    }
  }
}

}  // namespace
}  // namespace glint
