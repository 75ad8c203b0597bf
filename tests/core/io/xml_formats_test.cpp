#include "genus/io/xml_formats.h"

#include <gtest/gtest.h>

#include <string>

#include "core/io/sample_meshes.h"
#include "genus/base/error.h"
#include "genus/io/read_mesh.h"

namespace genus {
namespace {

#ifndef GENUS_XML_FORMATS

TEST(XmlFormats, SayThatTheyWereLeftOut)
{
    for (const MeshFormat format : {MeshFormat::three_mf, MeshFormat::amf})
        EXPECT_THROW(mesh_bytes(torus_mesh(4, 4), format), FileError);
}

#else

}  // namespace
}  // namespace genus

#include "genus/io/xml.h"
#include "genus/io/zip.h"

namespace genus {
namespace {

using Bytes = std::vector<std::byte>;
using Files = std::vector<std::pair<std::string, std::string>>;

Bytes zip(const Files& files)
{
    io::OutputBytes output("<zip>");
    io::ZipWriter writer(output);
    for (const auto& [name, text] : files)
        writer.add(name, [&content = text](io::Output& part) { part.write(content); });
    writer.finish();
    return std::move(output).take();
}

std::string message(const Bytes& bytes, const std::string& name)
{
    try {
        read_mesh_file(bytes, name);
        return "no error";
    } catch (const FileError& error) {
        return error.what();
    }
}

void expect_error(const Bytes& bytes, const std::string& name, const std::string& problem)
{
    EXPECT_NE(message(bytes, name).find(problem), std::string::npos)
        << problem << ", not: " << message(bytes, name);
}

Bytes bytes_of(std::string_view text)
{
    const auto bytes = as_bytes(text);
    return Bytes(bytes.begin(), bytes.end());
}

// ---- ZIP ----

TEST(Zip, UnpacksWhatItPacked)
{
    std::string large;
    for (int i = 0; i < 100'000; ++i) large += std::to_string(std::int64_t{i} * i % 7919);
    const std::string name = "a.zip";
    const Bytes bytes = zip({{"empty", ""}, {"dir/Large.txt", large}});
    const io::ZipArchive archive(bytes, name);
    ASSERT_EQ(archive.entries().size(), 2u);
    EXPECT_EQ(archive.find("missing"), nullptr);
    const auto* entry = archive.find("/DIR/large.TXT");
    ASSERT_NE(entry, nullptr);
    std::string unpacked;
    archive.unpack(
        *entry, [&](std::span<const char> piece) { unpacked.append(piece.data(), piece.size()); });
    EXPECT_TRUE(unpacked == large);
    EXPECT_LT(bytes.size(), large.size());
}

TEST(Zip, RefusesABomb)
{
    const Bytes bytes = zip({{"3D/3dmodel.model", "<model>" + std::string(80 << 20, ' ')}});
    EXPECT_LT(bytes.size(), 1u << 20);
    expect_error(bytes, "a.3mf", "far more than its size");
}

TEST(Zip, NoticesEveryDamagedByteOfAnEntry)
{
    const Bytes good = mesh_bytes(torus_mesh(4, 5), MeshFormat::three_mf);
    const std::string model = "3D/3dmodel.model";
    const io::ZipArchive archive(good, model);
    const auto* entry = archive.find(model);
    ASSERT_NE(entry, nullptr);
    const std::size_t data = entry->offset + 30 + model.size();
    for (std::size_t i = 0; i < entry->packed_size; ++i) {
        Bytes bad = good;
        bad[data + i] ^= std::byte{0x10};
        EXPECT_NE(message(bad, "a.3mf"), "no error") << i;
    }
}

// ---- XML ----

TEST(Xml, RefusesEntitiesAndDepth)
{
    expect_error(
        bytes_of("<?xml version=\"1.0\"?><!DOCTYPE amf [<!ENTITY a \"b\">]><amf>&a;</amf>"),
        "a.amf", "document types");
    std::string deep;
    for (int i = 0; i < 1000; ++i) deep += "<amf>";
    expect_error(bytes_of(deep), "a.amf", "too deeply");
    expect_error(bytes_of("<amf>\n<object id=\"0\">\n</amf>"), "a.amf", "a.amf:3: XML");
    expect_error(bytes_of("<amf><a b=\"" + std::string(8 << 20, 'x')), "a.amf", "longer than 1 MB");
    expect_error(bytes_of("<amf>"), "a.amf", "XML");
    expect_error(bytes_of("<amf unit=\"furlong\">"), "a.amf", "'furlong' is not a unit");
}

// ---- 3MF ----

const std::string kTetrahedron =
    "<mesh><vertices><vertex x=\"0\" y=\"0\" z=\"0\"/><vertex x=\"1\" y=\"0\" z=\"0\"/>"
    "<vertex x=\"0\" y=\"1\" z=\"0\"/><vertex x=\"0\" y=\"0\" z=\"1\"/></vertices><triangles>"
    "<triangle v1=\"0\" v2=\"2\" v3=\"1\"/><triangle v1=\"0\" v2=\"1\" v3=\"3\"/>"
    "<triangle v1=\"0\" v2=\"3\" v3=\"2\"/><triangle v1=\"1\" v2=\"2\" v3=\"3\"/>"
    "</triangles></mesh>";

std::string object(int id, const std::string& content)
{
    return "<object id=\"" + std::to_string(id) + "\">" + content + "</object>";
}

std::string model(const std::string& resources, const std::string& build,
                  const std::string& attributes = "")
{
    return "<model " + attributes + "><resources>" + resources + "</resources><build>" + build +
           "</build></model>";
}

Bytes three_mf(const std::string& text)
{
    return zip({{"3D/3dmodel.model", text}});
}

// Six times the volume enclosed.
double six_volumes(const IndexedMesh& mesh)
{
    double sum = 0.0;
    for (const Triangle& face : mesh.faces)
        sum += dot(mesh.vertices[face[0]], cross(mesh.vertices[face[1]], mesh.vertices[face[2]]));
    return sum;
}

TEST(ThreeMf, PlacesComponentsByTheirMaps)
{
    // Twice as large and mirrored; one more beside it.
    const std::string text = model(
        object(1, kTetrahedron) +
            object(
                2,
                "<components><component objectid=\"1\" transform=\"-2 0 0 0 2 0 0 0 2 0 0 0\"/>"
                "<component objectid=\"1\" transform=\"1 0 0 0 1 0 0 0 1 10 0 0\"/></components>"),
        "<item objectid=\"2\" transform=\"1 0 0 0 1 0 0 0 1 0 5 0\"/>", "unit=\"inch\"");
    const Bytes bytes = three_mf(text);
    const IndexedMesh mesh = read_mesh(bytes, "a.3mf");
    EXPECT_EQ(mesh.n_vertices(), 8u);
    EXPECT_EQ(mesh.vertices[1], (Vec3{{-2, 5, 0}}));
    EXPECT_EQ(mesh.vertices[5], (Vec3{{11, 5, 0}}));
    EXPECT_NEAR(six_volumes(mesh), 8.0 + 1.0, 1e-12);
    EXPECT_EQ(read_mesh_file(bytes, "a.3mf").unit, 25.4);
    EXPECT_EQ(read_mesh(bytes, "no extension"), mesh);
}

TEST(ThreeMf, FollowsRelationsAndOtherParts)
{
    const std::string root =
        model(object(7,
                     "<components><component objectid=\"1\" p:path=\"/3D/Objects/o.model\"/>"
                     "</components>"),
              "<item objectid=\"7\"/>",
              "xmlns:p=\"http://schemas.microsoft.com/3dmanufacturing/production/2015/06\" "
              "requiredextensions=\"p\"");
    const Files files = {{"_rels/.rels",
                          "<Relationships><Relationship Target=\"/other/a.model\" Id=\"r\" "
                          "Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/>"
                          "</Relationships>"},
                         {"other/a.model", root},
                         {"3D/objects/O.model", model(object(1, kTetrahedron), "")}};
    EXPECT_NEAR(six_volumes(read_mesh(zip(files), "a.3mf")), 1.0, 1e-15);
}

TEST(ThreeMf, ReadsColorsOfGroupsAndObjects)
{
    std::string mesh = kTetrahedron;
    mesh.replace(mesh.find("v3=\"3\"/>"), 8, "v3=\"3\" pid=\"6\" p1=\"1\" p2=\"0\" p3=\"0\"/>");
    const std::string text = model(
        "<basematerials id=\"5\"><base name=\"a\" displaycolor=\"#010203\"/></basematerials>"
        "<m:colorgroup id=\"6\"><m:color color=\"#0a0b0c\"/><m:color "
        "color=\"#FF00FF80\"/></m:colorgroup>"
        "<object id=\"1\" pid=\"5\" pindex=\"0\">" +
            mesh + "</object>",
        "<item objectid=\"1\"/>", "xmlns:m=\"x\"");
    const MeshFile file = read_mesh_file(three_mf(text), "a.3mf");
    const Rgba plain = {1, 2, 3, 255};
    EXPECT_EQ(file.face_colors, (std::vector<Rgba>{plain, {255, 0, 255, 128}, plain, plain}));
}

TEST(ThreeMf, NamesMistakes)
{
    const auto expect = [](const std::string& text, const std::string& problem) {
        expect_error(three_mf(text), "a.3mf", problem);
    };
    const std::string item = "<item objectid=\"1\"/>";
    expect(model(object(1, "<components><component objectid=\"1\"/></components>"), item),
           "circle");
    expect(model(object(1, "<components><component objectid=\"2\"/></components>") +
                     object(2, "<components><component objectid=\"1\"/></components>"),
                 item),
           "circle");
    expect(model("", item), "there is no object 1");
    expect(model(object(1, "") + object(1, ""), item), "comes twice");
    const auto with = [&](const std::string& from, const std::string& to) {
        std::string text = kTetrahedron;
        text.replace(text.find(from), from.size(), to);
        return model("\n" + object(1, text), item);
    };
    expect(with("v1=\"1\"", "v1=\"4\""), "3D/3dmodel.model, line 2: there is no vertex 4");
    expect(with("v1=\"1\"", "v1=\"-1\""), "v1: '-1' is not an index");
    expect(with("v1=\"1\"", "v1=\"1152921504606846976\""), "too large");
    expect(with("v1=\"1\"", ""), "'v1' is missing");
    expect(with("x=\"1\"", "x=\"nan\""), "not a finite number");
    expect(with("x=\"1\"", "x=\"1 2\""), "is not a number");
    expect(model(object(1, kTetrahedron), "<item objectid=\"1\" transform=\"1 0 0\"/>"),
           "transform");
    expect(model(object(1, kTetrahedron), "<item objectid=\"1\" p:path=\"/x\" xmlns:p=\"y\"/>"),
           "has no '/x'");
    expect(model("", "", "xmlns:b=\"http://x/beamlattice/2017\" requiredextensions=\"b\""),
           "beamlattice");
    expect_error(zip({{"a", "b"}}), "a.3mf", "has no '3D/3dmodel.model'");
    expect_error(bytes_of("PK\3\4"), "a.3mf", "ends too soon");
}

// Every object consists of ten of the one before it.
TEST(ThreeMf, BoundsWhatASmallFileCanAskFor)
{
    std::string resources = object(1, kTetrahedron);
    for (int id = 2; id < 20; ++id) {
        std::string components;
        for (int i = 0; i < 10; ++i)
            components += "<component objectid=\"" + std::to_string(id - 1) + "\"/>";
        resources += object(id, "<components>" + components + "</components>");
    }
    expect_error(three_mf(model(resources, "<item objectid=\"19\"/>")), "a.3mf", "too often");
}

TEST(ThreeMf, WritesTheUnitItKnows)
{
    MeshFile file;
    file.mesh = to_polygons(to_triangles(cut_cube()));
    for (const double unit : {25.4, 0.001, 304.8, 10.0}) {
        file.unit = unit;
        EXPECT_EQ(read_mesh_file(mesh_bytes(file, MeshFormat::three_mf), "a.3mf"), file);
    }
    file.unit = 2.0;
    const MeshFile scaled = read_mesh_file(mesh_bytes(file, MeshFormat::amf), "a.amf");
    EXPECT_EQ(scaled.unit, 1.0);
    EXPECT_EQ(scaled.mesh.vertices[0][0], -2.0);
}

// ---- AMF ----

std::string amf_object(int id, const std::string& color = "")
{
    return "<object id=\"" + std::to_string(id) +
           "\"><mesh><vertices><vertex><coordinates><x>0</x><y>0</y><z>0</z></coordinates></vertex>"
           "<vertex><coordinates><x> 1 </x><y>0</y><z>0</z></coordinates></vertex>"
           "<vertex><coordinates><x>0</x><y>1</y><z>0</z></coordinates></vertex></vertices>"
           "<volume materialid=\"3\">" +
           color + "<triangle><v1>0</v1><v2>1</v2><v3>2</v3></triangle></volume></mesh></object>";
}

TEST(Amf, PlacesConstellations)
{
    const Bytes bytes = bytes_of(
        "<?xml version=\"1.0\"?>\n<amf unit=\"feet\">" + amf_object(0) + amf_object(1) +
        "<constellation id=\"2\"><instance objectid=\"1\"><deltax>10</deltax><rz>90</rz></instance>"
        "<instance objectid=\"1\"><deltaz>1</deltaz></instance></constellation></amf>");
    const IndexedMesh mesh = read_mesh(bytes, "a.amf");
    ASSERT_EQ(mesh.n_vertices(), 9u);
    EXPECT_EQ(mesh.vertices[1], (Vec3{{1, 0, 0}}));
    EXPECT_EQ(mesh.vertices[4], (Vec3{{10, 1, 0}}));
    EXPECT_EQ(mesh.vertices[8], (Vec3{{0, 1, 1}}));
    EXPECT_EQ(read_mesh_file(bytes, "a.amf").unit, 304.8);
    EXPECT_EQ(read_mesh(bytes, "no extension"), mesh);
}

TEST(Amf, ReadsPackedFilesAndColors)
{
    const std::string color = "<color><r>1</r><g>.2</g><b>0</b></color>";
    const std::string material = "<material id=\"3\">" + color + "</material>";
    const std::string own = "<color><r>0</r><g>0</g><b>1</b><a>0</a></color>";
    const MeshFile of_material =
        read_mesh_file(zip({{"x.amf", "<amf>" + material + amf_object(0) + "</amf>"}}), "a.amf");
    EXPECT_EQ(of_material.face_colors, (std::vector<Rgba>{{255, 51, 0, 255}}));
    const MeshFile of_volume =
        read_mesh_file(bytes_of("<amf>" + amf_object(0, own) + material + "</amf>"), "a.amf");
    EXPECT_EQ(of_volume.face_colors, (std::vector<Rgba>{{0, 0, 255, 0}}));
    const std::string formula = "<color><r>x*2</r><g>0</g><b>0</b></color>";
    const MeshFile without =
        read_mesh_file(bytes_of("<amf>" + amf_object(0, formula) + "</amf>"), "a.amf");
    EXPECT_TRUE(without.face_colors.empty());
}

TEST(Amf, NamesMistakes)
{
    const auto expect = [](const std::string& text, const std::string& problem) {
        expect_error(bytes_of("<amf>\n" + text + "</amf>"), "a.amf", problem);
    };
    const auto with = [&](const std::string& from, const std::string& to) {
        std::string text = amf_object(0);
        return text.replace(text.find(from), from.size(), to);
    };
    expect(with("<v3>2", "<v3>3"), "a.amf:2: there is no vertex 3");
    expect(with("<v3>2</v3>", ""), "without v1, v2 and v3");
    expect(with("<x> 1 </x>", ""), "without x, y and z");
    expect(with("<x> 1 ", "<x>inf"), "not a finite number");
    expect(with("id=\"0\"", ""), "'id' is missing");
    expect(amf_object(0) + amf_object(0), "comes twice");
    expect("<vertex/>", "outside of an object");
    const std::string instance = "<instance objectid=\"1\"/>";
    expect("<constellation id=\"1\">" + instance + "</constellation>", "circle");
    expect("<constellation id=\"2\">" + instance + "</constellation>", "there is no object 1");
    expect(instance, "outside of a constellation");
}

#endif

}  // namespace
}  // namespace genus
