# Every panel of the paper's figures, drawn into $(OUT)/figures: `make figures`. What is there already is not computed again;
# `make -B figures` does it anew. docs/paper.md says which picture is which panel, and how long each takes. Beside them the
# pictures of equilibria in docs/pictures.md.
FIGURES := $(OUT)/figures
PLOT = $(BIN)/pddecont plot $< -o $@
WORKERS := 2

PANELS := fig4_1_diagram fig4_1_basins fig4_2_diagram fig4_2_basins fig4_2_delay_equation fig4_3a fig4_3b fig4_4_phase \
  fig4_4a_time fig4_4b_time fig4_4c_time fig4_4d_time fig4_5 fig4_6 fig4_6_points fig4_7 fig4_7_points \
  fig4_8a fig4_8b fig4_8cde
EQUILIBRIA := mackey_glass turning_lobes

figures: $(PANELS:%=$(FIGURES)/%.png) $(EQUILIBRIA:%=$(FIGURES)/%.png)   ## every panel of the paper's figures, in out/figures

# A run that is broken off leaves only its unfinished file.
define COMPUTE
	mkdir -p $(FIGURES)
	$(BIN)/pddecont run $< -o $(FIGURES)/$*_unfinished.h5 --overwrite --workers $(WORKERS)
	mv $(FIGURES)/$*_unfinished.h5 $@
endef
$(FIGURES)/%.h5: configs/%.yaml | setup
	$(COMPUTE)
$(FIGURES)/%.h5: models/%.yaml | setup
	$(COMPUTE)
.PRECIOUS: $(FIGURES)/%.h5

$(FIGURES)/fig4_1_diagram.png: $(FIGURES)/fig4_1.h5
	$(PLOT) --view sweep
$(FIGURES)/fig4_1_basins.png: $(FIGURES)/fig4_1.h5
	$(PLOT) --view basin
$(FIGURES)/fig4_2_diagram.png: $(FIGURES)/fig4_2.h5
	$(PLOT) --view sweep
$(FIGURES)/fig4_2_delay_equation.png: $(FIGURES)/fig4_2_delay_equation.h5
	$(PLOT) --view sweep
$(FIGURES)/fig4_2_basins.png: $(FIGURES)/fig4_2_delay_equation.h5
	$(PLOT) --view basin
$(FIGURES)/fig4_3a.png: $(FIGURES)/fig4_3.h5
	$(PLOT) --step two_impacts
$(FIGURES)/fig4_3b.png: $(FIGURES)/fig4_3.h5
	$(PLOT) --step one_impact
$(FIGURES)/fig4_4_phase.png: $(FIGURES)/fig4_4.h5
	$(PLOT) --view orbit $(foreach tau,3_8 4_6 5_9 7_1,--step chain_$(tau) --step delay_$(tau))
$(FIGURES)/fig4_4a_time.png: TIME = 3_8
$(FIGURES)/fig4_4b_time.png: TIME = 4_6
$(FIGURES)/fig4_4c_time.png: TIME = 5_9
$(FIGURES)/fig4_4d_time.png: TIME = 7_1
$(FIGURES)/fig4_4%_time.png: $(FIGURES)/fig4_4.h5
	$(PLOT) --view profile --step chain_$(TIME) -y v
$(FIGURES)/fig4_5.png: $(FIGURES)/fig4_5.h5
	$(PLOT) --view distance
$(FIGURES)/fig4_6.png: $(FIGURES)/fig4_6.h5
	$(PLOT) -x tau_d -y h_GR --label GR1 --label GR2
$(FIGURES)/fig4_6_points.png: $(FIGURES)/fig4_6.h5
	$(PLOT) --step in_delay --view orbit --label GR1 --label GR2 --label UF1 --label UF3 --label UF2
$(FIGURES)/fig4_7.png: $(FIGURES)/fig4_7.h5
	$(PLOT) -x K -y contact_time --label GR1
$(FIGURES)/fig4_7_points.png: $(FIGURES)/fig4_7.h5
	$(PLOT) --step in_gain --view orbit --label EP1 --label UF1 --label UF2 --label GR1
$(FIGURES)/fig4_8a.png: $(FIGURES)/fig4_8.h5
	$(PLOT) --view plane
$(FIGURES)/fig4_8b.png: $(FIGURES)/fig4_8.h5
	$(PLOT) --step grazing --view manifold -x v -y "v(t - tau_d)" -z tau_d
$(FIGURES)/fig4_8cde.png: $(FIGURES)/fig4_8_points.h5
	$(PLOT) --view orbit $(foreach point,P1 P2 P3,--step chain_$(point) --step delay_$(point))

$(FIGURES)/mackey_glass.png: $(FIGURES)/mackey_glass.h5
	$(PLOT) --step at_rest --step in_delay --step doubled
$(FIGURES)/turning_lobes.png: $(FIGURES)/turning_lobes.h5
	$(PLOT) --view plane
