"""From receptance to Green's function to moving Green's function, as the paper prints it (Eqs 1-3, 13, 15)."""
