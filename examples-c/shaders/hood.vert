#version 450
// The header beside this file is its SPIR-V, so that nobody needs a compiler to build the examples:
//
//     glslangValidator -V hood.vert --target-env vulkan1.1 --vn hood_vert -o hood.vert.h

layout(push_constant) uniform Camera {
    mat4 projection;
    mat4 model_view; // a rotation and a translation
};

layout(location = 0) in vec3 position; // m, z up
layout(location = 1) in vec4 normal;   // w: 0 of the hood, 1 of the ground

layout(location = 0) out vec3 surface;
layout(location = 1) out vec4 facing;
layout(location = 2) flat out vec3 eye;

void main() {
    gl_Position = projection * (model_view * vec4(position, 1));
    surface = position;
    facing = normal;
    eye = -transpose(mat3(model_view)) * model_view[3].xyz;
}
