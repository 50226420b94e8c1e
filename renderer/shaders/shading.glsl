/* Blinn-Phong with the light at the eye, two-sided: light, view and half vector are one. A zero gradient has no side,
 * nor has one that overflows, so only the ambient part is left. */
uniform mat3 normal_matrix; /* gradient in the level's index space -> world: inverse transpose */
uniform vec4 material;      /* ambient, diffuse, specular, shininess */

vec3 shade(vec3 rgb, vec3 gradient, vec3 view)
{
    precise vec3 n = normal_matrix[0] * gradient.x + normal_matrix[1] * gradient.y + normal_matrix[2] * gradient.z;
    precise float total = abs(n.x) + abs(n.y) + abs(n.z);
    if (!(total > 0.0 && total <= 3.0e38))
        return rgb * material.x;
    n /= max(abs(n.x), max(abs(n.y), abs(n.z)));
    precise float along = (n.x * view.x + n.y * view.y + n.z * view.z) / sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
    float facing = min(abs(along), 1.0);
    precise vec3 lit = rgb * (material.x + material.y * facing) + material.z * power(facing, material.w);
    return lit;
}
